// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/network/inference.hpp"
#include "edvo/network/onednn_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core/utility.hpp>
#include <optional>

// Of libgomp, by whose threads oneDNN works; clang comes without its omp.h.
extern "C" {
void omp_set_num_threads(int count);
int omp_get_max_threads();
}

namespace edvo {
namespace {

// oneDNN's threads are OpenMP's, whose number belongs to the thread that asks.
class ThreadCount {
 public:
  explicit ThreadCount(int count) { omp_set_num_threads(count); }
  ~ThreadCount() { omp_set_num_threads(before_); }
  ThreadCount(const ThreadCount&) = delete;
  ThreadCount& operator=(const ThreadCount&) = delete;

 private:
  int before_ = omp_get_max_threads();
};

// Threads meet after each layer, spinning, and wait for one that a busy core has put off. With
// fewer weights a layer takes less than that: such a network runs on one thread, beside others.
constexpr std::size_t kManyWeights = 1'000'000;

std::size_t weights_in(const OnnxGraph& graph) {
  std::size_t bytes = 0;
  for (const auto& [name, tensor] : graph.constants) bytes += tensor.data.size();
  return bytes / sizeof(float);
}

class OneDnnInference final : public Inference {
 public:
  OneDnnInference(OnnxGraph graph, std::string output, cv::Size size)
      : output_(std::move(output)), graph_(std::move(graph)) {
    const ThreadCount threads(thread_count());
    prepare({1, 3, size.height, size.width});
  }

  [[nodiscard]] cv::Mat forward(const cv::Mat_<cv::Vec3f>& image) override {
    const ThreadCount threads(thread_count());
    prepare({1, 3, image.rows, image.cols});
    try {
      return run(*plan_, image);
    } catch (const dnnl::error& error) {
      refuse(plan_->image, error.what());
    }
  }

 private:
  [[nodiscard]] int thread_count() const {
    return is_large_ ? std::max(1, cv::getNumThreads()) : 1;
  }

  void prepare(const dnnl::memory::dims& image) {
    if (plan_ && plan_->image == image) return;
    plan_.reset();  // its memory serves the next
    try {
      plan_ = plan_network(graph_, output_, image);
    } catch (const dnnl::error& error) {
      refuse(image, error.what());
    } catch (const Error& error) {
      refuse(image, error.what());
    }
  }

  [[noreturn]] static void refuse(const dnnl::memory::dims& image, const char* reason) {
    throw Error(ErrorCode::kModel,
                fmt::format("oneDNN {} cannot run this network on an image of {} x {} px: {}",
                            onednn_version(), image[3], image[2], reason));
  }

  std::string output_;
  OnnxGraph graph_;
  bool is_large_ = weights_in(graph_) > kManyWeights;
  std::optional<NetworkPlan> plan_;
};

}  // namespace

std::string onednn_version() {
  const dnnl_version_t& version = *dnnl::version();
  return fmt::format("{}.{}.{}", version.major, version.minor, version.patch);
}

std::unique_ptr<Inference> make_onednn_inference(OnnxGraph graph, const std::string& output,
                                                 cv::Size size) {
  return std::make_unique<OneDnnInference>(std::move(graph), output, size);
}

}  // namespace edvo
