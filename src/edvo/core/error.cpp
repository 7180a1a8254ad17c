// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"

#include <opencv2/core.hpp>

#include <new>
#include <system_error>

namespace edvo {
namespace {

Error lacking(const std::string& what) {
  return {ErrorCode::kResources,
          what + "; close other programs or lift the limit (ulimit -a shows them)"};
}

}  // namespace

Error caught_error() {
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    return lacking("not enough memory");
  } catch (const std::system_error& error) {
    return lacking(error.what());
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) return lacking("not enough memory");
    return {ErrorCode::kInternal, error.what()};
  } catch (const std::exception& error) {
    return {ErrorCode::kInternal, error.what()};
  }
}

}  // namespace edvo
