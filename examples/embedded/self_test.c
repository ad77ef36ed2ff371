/* Hashes of every stage's output, each view by itself: equal on every build and processor that computes right.
 *
 * self_test SEQUENCE [ISA] */
#include "pool.h"
#include "program.h"
#include "telemetry.h"

enum { THETA_ROWS = 180, MAX_SEGMENTS = 4096 };

/* Outputs of one view's stages. */
typedef struct Outputs {
  size_t pixels, words, cells;
  uint8_t* smoothed;
  uint8_t* direction;
  uint32_t* bits;
  rvdnav_edgel* edgels;
  uint16_t* accumulator;
  rvdnav_peak* peaks;
  rvdnav_segment* segments;
} Outputs;

static void put_stage(const char* stage, const void* output, size_t size) {
  put(" ");
  put(stage);
  put(" ");
  put_hash(hash(HASH_START, output, size));
}

static Outputs take_outputs(const Sequence* sequence) {
  Outputs out;
  const size_t width = (size_t)sequence->rig.width, height = (size_t)sequence->rig.height;
  out.pixels = width * height;
  out.words = rvdnav_edge_row_words(sequence->rig.width) * height;
  out.cells = (size_t)THETA_ROWS * (size_t)sequence->config.hough_rho_bins;
  out.smoothed = pool_take(out.pixels);
  out.direction = pool_take(out.pixels);
  out.bits = pool_take(out.words * sizeof *out.bits);
  out.edgels = pool_take((size_t)sequence->config.max_edgels * sizeof *out.edgels);
  out.accumulator = pool_take(out.cells * sizeof *out.accumulator);
  out.peaks = pool_take((size_t)sequence->config.max_peaks * sizeof *out.peaks);
  out.segments = pool_take(MAX_SEGMENTS * sizeof *out.segments);
  return out;
}

/* The stages one by one, each on the output of the one before. */
static void put_stages(const rvdnav_config* config, rvdnav_context* context, int32_t camera, const rvdnav_image* image,
                       const Outputs* out) {
  check(rvdnav_smooth(context, camera, image, out->smoothed), "rvdnav_smooth");
  put_stage("smooth", out->smoothed, out->pixels);

  const size_t bit_bytes = out->words * sizeof *out->bits;
  check(rvdnav_detect_edges(context, camera, out->smoothed, out->bits, out->direction), "rvdnav_detect_edges");
  put_stage("edges", out->bits, bit_bytes);
  put_stage("direction", out->direction, out->pixels);
  check(rvdnav_filter_edges(context, camera, out->bits), "rvdnav_filter_edges");
  put_stage("filter", out->bits, bit_bytes);
  check(rvdnav_thin(context, camera, out->bits), "rvdnav_thin");
  put_stage("thin", out->bits, bit_bytes);

  uint32_t edgels = 0, peaks = 0, segments = 0;
  check(rvdnav_rectify_edges(context, camera, out->bits, out->direction, out->edgels, (uint32_t)config->max_edgels,
                             &edgels),
        "rvdnav_rectify_edges");
  put_stage("rectify", out->edgels, edgels * sizeof *out->edgels);
  check(rvdnav_hough_vote(context, out->edgels, edgels, out->accumulator), "rvdnav_hough_vote");
  put_stage("votes", out->accumulator, out->cells * sizeof *out->accumulator);
  check(rvdnav_hough_peaks(context, out->accumulator, out->peaks, (uint32_t)config->max_peaks, &peaks),
        "rvdnav_hough_peaks");
  put_stage("peaks", out->peaks, peaks * sizeof *out->peaks);
  check(rvdnav_extract_segments(context, camera, out->edgels, edgels, out->peaks, peaks, out->segments, MAX_SEGMENTS,
                                &segments),
        "rvdnav_extract_segments");
  put_stage("segments", out->segments, segments * sizeof *out->segments);
}

int main(int argc, char** argv) {
  static Sequence sequence;
  rvdnav_context* context = program_start(argc, argv, &sequence);
  const Outputs outputs = take_outputs(&sequence);
  for (uint32_t number = 0; number < sequence.frame_count; ++number) {
    Frame frame;
    sequence_read(&sequence, &frame);
    for (int32_t camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
      if (!frame.has[camera]) continue;
      put("frame ");
      put_unsigned((uint64_t)frame.stamp_ns);
      put(camera == 0 ? " left" : " right");
      put_stages(&sequence.config, context, camera, &frame.image[camera], &outputs);
      put_newline();
    }
  }
  put_memory();
  return 0;
}
