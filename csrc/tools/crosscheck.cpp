// Holds the integer stages against OpenCV's.  Usage: crosscheck IMAGE...   Exit code 0: all agree.
#include <cmath>
#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lens.hpp"
#include "stages.hpp"

using namespace rvdnav;

namespace {

int failures = 0;

void report(const char* name, bool good, const char* what, double value) {
  std::printf("%-12s %s  %s %.4g\n", name, good ? "ok  " : "FAIL", what, value);
  failures += good ? 0 : 1;
}

cv::Mat mat_of(std::vector<uint8_t>& pixels, const cv::Size& size) { return cv::Mat(size, CV_8U, pixels.data()); }

void check_smooth(Stages& stages, const cv::Mat& image) {
  cv::Mat expected;
  cv::GaussianBlur(image, expected, cv::Size(3, 3), 0, 0, cv::BORDER_REPLICATE);
  stages.run_smooth(image.data);
  report("smooth", cv::norm(expected, mat_of(stages.smoothed, image.size()), cv::NORM_INF) == 0,
         "grey levels beside GaussianBlur, at most",
         cv::norm(expected, mat_of(stages.smoothed, image.size()), cv::NORM_INF));
}

// The rows' magnitudes against cv::Sobel and its turned kernels.
void check_gradient(Stages& stages, const cv::Mat& image, const Kernels& kernels) {
  const cv::Mat smoothed = mat_of(stages.smoothed, image.size());
  cv::Mat gx, gy, g45, g135;
  cv::Sobel(smoothed, gx, CV_16S, 1, 0);
  cv::Sobel(smoothed, gy, CV_16S, 0, 1);
  cv::filter2D(smoothed, g45, CV_16S, cv::Matx33f(-2, -1, 0, -1, 0, 1, 0, 1, 2));
  cv::filter2D(smoothed, g135, CV_16S, cv::Matx33f(0, -1, -2, 1, 0, -1, 2, 1, 0));
  cv::Mat expected = cv::abs(gx);
  for (const cv::Mat& other : {gy, g45, g135}) expected = cv::max(expected, cv::Mat(cv::abs(other)));
  cv::Mat magnitude = cv::Mat::zeros(image.size(), CV_16S), code = cv::Mat::zeros(image.size(), CV_8U);
  for (int y = 1; y < image.rows - 1; ++y) {
    kernels.gradient_row(smoothed.ptr(y - 1), smoothed.ptr(y), smoothed.ptr(y + 1), image.cols,
                         make_threshold_curve(1, 0, 255), magnitude.ptr<int16_t>(y), code.ptr(y));
  }
  const cv::Rect inner(1, 1, image.cols - 2, image.rows - 2);
  const double off = cv::norm(expected(inner), magnitude(inner), cv::NORM_INF);
  report("gradient", off == 0, "beside Sobel, at most", off);
}

// Canny finds its edges another way: most of the strong ones must be ours too, a pixel aside at most.
void check_canny(Stages& stages, const cv::Mat& image) {
  cv::Mat canny, ours = cv::Mat::zeros(image.size(), CV_8U), near_ours;
  cv::Canny(mat_of(stages.smoothed, image.size()), canny, 50, 150);
  stages.run_edges();
  stages.run_thin();
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      if (stages.edge(x, y)) ours.at<uint8_t>(y, x) = 255;
  cv::dilate(ours, near_ours, cv::Mat::ones(3, 3, CV_8U));
  const double shared = cv::countNonZero(canny & near_ours) / static_cast<double>(cv::countNonZero(canny));
  report("edges", shared > 0.9, "share of Canny's edges", shared);
}

void check_lens(const rvdnav_rig& rig, const Stages& stages) {
  const rvdnav_camera& c = rig.camera[0];
  const cv::Matx33d K(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1), R(c.R_rect_cam);
  const cv::Matx33d P(rig.focal_rect, 0, 0, 0, rig.focal_rect, 0, 0, 0, 1);
  std::vector<cv::Point2d> raw, rect;
  for (int v = 0; v < rig.height; v += 7)
    for (int u = 0; u < rig.width; u += 7) raw.emplace_back(u, v);
  cv::undistortPoints(raw, rect, K, cv::Vec4d(c.k1, c.k2, c.p1, c.p2), R, P,
                      cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-12));
  double exact = 0, mapped = 0;
  for (size_t i = 0; i < raw.size(); ++i) {
    double x = 0, y = 0;
    if (!raw_to_rect(rig, 0, raw[i].x, raw[i].y, &x, &y)) exact = INFINITY;
    exact = std::fmax(exact, std::hypot(x - rect[i].x, y - rect[i].y));
    int32_t xq = 0, yq = 0;
    raw_to_rect_q5(stages.map(), static_cast<int32_t>(raw[i].x) * 32, static_cast<int32_t>(raw[i].y) * 32, &xq, &yq);
    mapped = std::fmax(mapped, std::fmax(std::fabs(xq / 32.0 - rect[i].x), std::fabs(yq / 32.0 - rect[i].y)));
  }
  report("lens", exact < 1e-6, "pixels beside undistortPoints, at most", exact);
  report("lens map", mapped < 0.031, "pixels beside undistortPoints, at most", mapped);
}

// Every line that HoughLines finds in a drawing is a peak of ours: the same edge pixels, seen through a pinhole.
void check_hough(const Kernels& kernels) {
  cv::Mat drawing(576, 704, CV_8U, cv::Scalar(40));
  const cv::Point quad[2][4] = {{{150, 120}, {420, 90}, {470, 330}, {120, 400}},
                                {{480, 380}, {640, 300}, {660, 520}, {500, 540}}};
  for (const auto& corners : quad) cv::fillConvexPoly(drawing, corners, 4, cv::Scalar(160), cv::LINE_AA);
  Stages stages(pinhole_rig(drawing.cols, drawing.rows), kernels);
  stages.run_smooth(drawing.data);
  stages.run_edges();
  stages.run_thin();
  stages.run_rectify();
  stages.run_vote();
  stages.run_peaks();
  cv::Mat edges = cv::Mat::zeros(drawing.size(), CV_8U);
  for (int y = 0; y < drawing.rows; ++y)
    for (int x = 0; x < drawing.cols; ++x)
      if (stages.edge(x, y)) edges.at<uint8_t>(y, x) = 255;
  std::vector<cv::Vec2f> lines;
  cv::HoughLines(edges, lines, 1, CV_PI / 180, 70);
  double worst = 0;
  for (const cv::Vec2f& line : lines) {
    double nearest = INFINITY;
    for (const rvdnav_peak& peak : stages.peaks) {
      double theta = peak.theta_q8 / 256.0 * CV_PI / 180, rho = peak.rho_q8 / 256.0;
      rho += std::cos(theta) * (drawing.cols - 1) / 2.0 + std::sin(theta) * (drawing.rows - 1) / 2.0;
      if (theta < 0) {
        theta += CV_PI;
        rho = -rho;
      }
      const double turn = std::fabs(theta - line[1]);
      const bool other_side = turn > CV_PI / 2;
      const double degrees = (other_side ? CV_PI - turn : turn) * 180 / CV_PI;
      nearest = std::fmin(nearest, std::fmax(std::fabs((other_side ? -rho : rho) - line[0]) / 8, degrees));
    }
    worst = std::fmax(worst, nearest);
  }
  std::printf("%zu lines of HoughLines, %zu peaks\n", lines.size(), stages.peaks.size());
  // Beside the middle of the image a degree is some pixels.
  report("Hough", !lines.empty() && worst <= 2, "degrees (or 8 pixels) from the nearest peak, at most", worst);
}

}  // namespace

int main(int argc, char** argv) {
  const Kernels& kernels = *select_kernels(RVDNAV_ISA_AUTO);
  for (int i = 1; i < argc; ++i) {
    const cv::Mat image = cv::imread(argv[i], cv::IMREAD_GRAYSCALE);
    if (image.empty()) {
      std::fprintf(stderr, "crosscheck: %s: not an image\n", argv[i]);
      return 2;
    }
    const rvdnav_rig rig = typical_rig(image.cols, image.rows);
    Stages stages(rig, kernels);
    if (!stages.mapped()) {
      std::fprintf(stderr, "crosscheck: %s: too large for the lens map\n", argv[i]);
      return 2;
    }
    std::printf("%s\n", argv[i]);
    check_smooth(stages, image);
    check_gradient(stages, image, kernels);
    check_canny(stages, image);
    check_lens(rig, stages);
  }
  check_hough(kernels);
  return failures == 0 ? 0 : 1;
}
