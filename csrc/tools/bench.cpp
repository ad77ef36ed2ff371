// Times the integer stages of one view beside OpenCV's Canny and HoughLines, on one thread.  Usage: bench IMAGE...
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "stages.hpp"

using namespace rvdnav;

namespace {

constexpr int kRuns = 31;

double median_ms(const std::function<void()>& prepare, const std::function<void()>& run) {
  std::vector<double> times;
  for (int i = 0; i < kRuns; ++i) {
    prepare();
    const auto start = std::chrono::steady_clock::now();
    run();
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::nth_element(times.begin(), times.begin() + kRuns / 2, times.end());
  return times[kRuns / 2];
}

void bench(const cv::Mat& image, const Kernels& kernels) {
  Stages stages(typical_rig(image.cols, image.rows), kernels);
  const auto nothing = [] {};
  struct Row {
    const char* name;
    double ms;
  };
  std::vector<Row> rows;
  rows.push_back({"smooth", median_ms(nothing, [&] { stages.run_smooth(image.data); })});
  rows.push_back({"edges", median_ms(nothing, [&] { stages.run_edges(); })});
  rows.push_back({"filter, thin", median_ms([&] { stages.run_edges(); }, [&] { stages.run_thin(); })});
  rows.push_back({"rectify", median_ms(nothing, [&] { stages.run_rectify(); })});
  rows.push_back({"Hough vote", median_ms(nothing, [&] { stages.run_vote(); })});
  rows.push_back({"Hough peaks", median_ms(nothing, [&] { stages.run_peaks(); })});
  double sum = 0;
  for (const Row& row : rows) {
    std::printf("  %-22s %7.3f ms\n", row.name, row.ms);
    sum += row.ms;
  }
  std::printf("  %-22s %7.3f ms   %zu edgels, %zu peaks\n", "all", sum, stages.edgels.size(), stages.peaks.size());

  cv::Mat canny;
  std::vector<cv::Vec2f> lines;
  std::printf("  %-22s %7.3f ms\n", "cv::Canny(50, 150)",
              median_ms(nothing, [&] { cv::Canny(image, canny, 50, 150); }));
  std::printf("  %-22s %7.3f ms   %d edge pixels\n", "cv::HoughLines",
              median_ms(nothing, [&] { cv::HoughLines(canny, lines, 1, CV_PI / 180, 60); }), cv::countNonZero(canny));
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  for (int i = 1; i < argc; ++i) {
    const cv::Mat image = cv::imread(argv[i], cv::IMREAD_GRAYSCALE);
    if (image.empty()) {
      std::fprintf(stderr, "bench: %s: not an image\n", argv[i]);
      return 2;
    }
    for (const auto& [isa, name] : {std::pair{RVDNAV_ISA_SCALAR, "scalar"},
                                    {RVDNAV_ISA_SSE2, "sse2"},
                                    {RVDNAV_ISA_AVX2, "avx2"},
                                    {RVDNAV_ISA_NEON, "neon"}}) {
      const Kernels* kernels = select_kernels(isa);
      if (kernels == nullptr) continue;
      std::printf("%s, %s\n", argv[i], name);
      bench(image, *kernels);
    }
  }
  return 0;
}
