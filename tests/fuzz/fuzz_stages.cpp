// The stages, each by itself: what one gives is disturbed before it is given to the next.
#include <algorithm>

#include "parts.hpp"

namespace {

constexpr int32_t kThetaBins = 180;

// A list as a stage fills it: as many as fit.
template <typename T>
class List {
 public:
  List(Input& input, uint32_t most) : items_(input.one_in(8) ? input.below(16) : most) {}

  T* data() { return items_.data(); }
  uint32_t capacity() const { return static_cast<uint32_t>(items_.size()); }
  uint32_t* count() { return &count_; }

  // What was written, disturbed.
  std::vector<T> taken(Input& input) {
    items_.resize(std::min(count_, capacity()));
    disturb_all(input, 4, &items_);
    return items_;
  }

 private:
  std::vector<T> items_;
  uint32_t count_ = 0;
};

template <typename T>
uint32_t count_of(const std::vector<T>& items) {
  return static_cast<uint32_t>(items.size());
}

rvdnav_window window_from(Input& input) {
  std::vector<rvdnav_window> window(1, {0, 0, -12.0, 0.0, 3.0, 0.1, -10.0, 10.0});
  disturb_all(input, 3, &window);
  return window[0];
}

// Scattered, or along one of the usual lines: many enough for peaks and segments.
std::vector<rvdnav_edgel> edgels_from(Input& input, const rvdnav_config& config) {
  std::vector<rvdnav_edgel> edgels(std::min(input.take<uint8_t>() * 2U, static_cast<uint32_t>(config.max_edgels)));
  Noise random(input);
  const uint32_t scatter = 1U + input.below(64);
  int32_t along_q5 = -600;
  for (rvdnav_edgel& e : edgels) {
    const auto across_q5 = static_cast<int32_t>(random.next() % scatter);
    const bool upright = random.next() % 2 == 0;
    const auto first = static_cast<uint8_t>(random.next() % 2 * 128);
    along_q5 += 20;
    e = upright ? rvdnav_edgel{-384 + across_q5, along_q5, first, {}}
                : rvdnav_edgel{along_q5, 384 + across_q5, static_cast<uint8_t>(first + 64), {}};
    if (along_q5 > 600) along_q5 = -600;
  }
  disturb_all(input, 4, &edgels);
  return edgels;
}

}  // namespace

void fuzz_image_stages(Input& input) {
  Prepared prepared;
  if (!prepare(input, &prepared)) return;
  rvdnav_context* context = prepared.context;
  const rvdnav_rig& rig = prepared.rig;
  const int32_t camera = input.one_in(16) ? input.take<int8_t>() : 0;
  const Picture picture(input, rig);
  const size_t pixels = static_cast<size_t>(rig.width) * static_cast<size_t>(rig.height);
  std::vector<uint8_t> smoothed(pixels), direction(pixels);
  std::vector<uint32_t> bits(rvdnav_edge_row_words(rig.width) * static_cast<size_t>(rig.height));
  rvdnav_smooth(context, camera, picture.image(), smoothed.data());
  rvdnav_detect_edges(context, camera, smoothed.data(), bits.data(), direction.data());
  disturb_all(input, 8, &bits);
  rvdnav_filter_edges(context, camera, bits.data());
  disturb_all(input, 8, &bits);
  rvdnav_thin(context, camera, bits.data());
  disturb_all(input, 4, &bits);
  List<rvdnav_edgel> edgels(input, static_cast<uint32_t>(pixels));
  rvdnav_rectify_edges(context, camera, bits.data(), direction.data(), edgels.data(), edgels.capacity(),
                       edgels.count());
}

void fuzz_line_stages(Input& input) {
  Prepared prepared;
  if (!prepare(input, &prepared)) return;
  rvdnav_context* context = prepared.context;
  if (prepared.config.hough_rho_bins > 512) return;  // slow
  const std::vector<rvdnav_edgel> edgels = edgels_from(input, prepared.config);
  std::vector<uint16_t> votes(kThetaBins * static_cast<size_t>(prepared.config.hough_rho_bins));
  rvdnav_hough_vote(context, edgels.data(), count_of(edgels), votes.data());
  if (votes.size() >= 4) disturb_all(input, 8, &votes);
  List<rvdnav_peak> found(input, 512);
  rvdnav_hough_peaks(context, votes.data(), found.data(), found.capacity(), found.count());
  std::vector<rvdnav_peak> peaks = found.taken(input);
  const rvdnav_window window = window_from(input);
  rvdnav_peak tracked = {};
  rvdnav_hough_track(context, 0, edgels.data(), count_of(edgels), &window, 1, &tracked);
  peaks.push_back(tracked);
  List<rvdnav_segment> fitted(input, 64);
  rvdnav_extract_segments(context, 0, edgels.data(), count_of(edgels), peaks.data(), count_of(peaks), fitted.data(),
                          fitted.capacity(), fitted.count());
  const std::vector<rvdnav_segment> segments = fitted.taken(input);
  List<rvdnav_bar> bars(input, 64);
  rvdnav_find_bars(context, 0, segments.data(), count_of(segments), bars.data(), bars.capacity(), bars.count());
}

void fuzz_geometry(Input& input) {
  Prepared prepared;
  if (!prepare(input, &prepared)) return;
  rvdnav_context* context = prepared.context;
  const Picture left(input, prepared.rig), right(input, prepared.rig);
  const rvdnav_image* const second = prepared.rig.camera_count == RVDNAV_CAMERAS ? right.image() : nullptr;

  std::vector<rvdnav_model_edge> edges(2, {-12.0, -10.0, -11.0, 10.0, 4.0, 0.0, 0, 0});
  disturb_all(input, 4, &edges);
  double half_width = 3.5, step = 1.0, blur = 0.0, shortest = 4.0;
  for (double* number : {&half_width, &step, &blur, &shortest}) {
    if (input.one_in(8)) *number = input.real();
  }
  List<rvdnav_edge_sample> samples(input, 64);
  rvdnav_measure_edges(context, 0, left.image(), edges.data(), count_of(edges), half_width, step, blur, samples.data(),
                       samples.capacity(), samples.count());

  std::vector<rvdnav_seen_edge> seen(3, {{{-0.3, -0.25, 1.0}, {-0.28, 0.25, 1.0}}, {0.0, 0.0}, 4.0, 0.0, 0, 0});
  seen[1].camera = second != nullptr ? 1 : 0;
  disturb_all(input, 6, &seen);
  constexpr uint32_t kProfiles = 80;
  List<rvdnav_edge_sample> many(input, kProfiles * count_of(seen));
  std::vector<rvdnav_edge_coverage> coverage(seen.size());
  rvdnav_sample_edges(context, left.image(), input.one_in(16) ? nullptr : second, seen.data(), count_of(seen),
                      half_width, shortest, many.data(), many.capacity(), many.count(), coverage.data());

  std::vector<rvdnav_match> matches(2);
  for (rvdnav_match& match : matches) match = {edges[0].x0, edges[0].y0, 0.0, 0.0, {0.0, 0.0, 0.0}, -1, 0};
  disturb_all(input, 4, &matches);
  rvdnav_correlate(context, left.image(), second, matches.data(), count_of(matches));
  const double from[2] = {edges[0].x0, edges[0].y0}, to[2] = {edges[1].x1, edges[1].y1};
  double p_W[3];
  rvdnav_triangulate(context, from, to, 1, p_W);
}

void fuzz_surface(Input& input) {
  Prepared prepared;
  if (!prepare(input, &prepared)) return;
  const Picture left(input, prepared.rig), right(input, prepared.rig);
  size_t size = 0;
  if (rvdnav_surface_size(prepared.context, &size) != RVDNAV_OK) return;
  const Memory memory = aligned(size);
  List<rvdnav_surface_point> points(input, 256);
  uint32_t crossings = 0;
  rvdnav_surface(prepared.context, left.image(), right.image(), memory.get(), size, points.data(), points.capacity(),
                 points.count(), &crossings);
}

void fuzz_images(Input& input) {
  constexpr int32_t kMostBytes = 1 << 16;
  const int32_t width = 1 + input.take<uint8_t>(), height = 1 + input.take<uint8_t>();
  const int32_t stride = width + static_cast<int32_t>(input.below(40));
  if (stride * height > kMostBytes) return;
  const Picture picture(input, width, height, stride);
  rvdnav_image image = *picture.image();
  if (input.one_in(16)) {  // one that is refused
    int32_t* const numbers[] = {&image.width, &image.height, &image.stride};
    const auto value = input.take<int32_t>();
    *numbers[input.below(3)] = value > 0 && value <= 4096 ? 0 : value;
    if (image.stride >= width && image.width == width && image.height == height) return;
  }
  uint64_t digest = 0;
  rvdnav_image_digest(&image, &digest);
  uint32_t median = 0;
  rvdnav_noise_median(&image, &median);
  rvdnav_fields fields = {};
  fields.struct_size = input.one_in(16) ? input.take<uint32_t>() : static_cast<uint32_t>(sizeof(fields));
  rvdnav_find_fields(&image, &fields);
}
