// SPDX-License-Identifier: MIT
#include "edvo/io/jpeg.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <turbojpeg.h>

#include <memory>

namespace edvo {

std::string encode_jpeg(const cv::Mat& image, int quality) {
  const bool is_gray = image.type() == CV_8UC1;
  if (image.empty() || (!is_gray && image.type() != CV_8UC3))
    throw Error(ErrorCode::kInternal, "a JPEG is made of 8 bit gray or BGR pixels only");
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), &tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): the library's type
  const int status =
      encoder ? tjCompress2(encoder.get(), image.data, image.cols, static_cast<int>(image.step),
                            image.rows, is_gray ? TJPF_GRAY : TJPF_BGR, &bytes, &size,
                            is_gray ? TJSAMP_GRAY : TJSAMP_420, quality, 0)
              : -1;
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(bytes, &tjFree);
  if (status != 0)
    throw Error(ErrorCode::kInternal,
                fmt::format("cannot compress a picture: {}", tjGetErrorStr2(encoder.get())));
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace edvo
