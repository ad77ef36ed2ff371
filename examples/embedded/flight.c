/* A flight program: stereo images in, poses of the bracket out, with or without an operating system.
 *
 * flight SEQUENCE [ISA]
 *
 * The bracket is searched for in every frame by itself.  Each frame's line ends with a hash of all that the core gave:
 * it is the same on every build. */
#include <stdbool.h>
#include <stddef.h>

#include "program.h"
#include "telemetry.h"

/* The views one after the other, then both together. */
static void acquire(rvdnav_context* context, const Frame* frame, rvdnav_frame_result* result) {
  static rvdnav_view_result view[RVDNAV_CAMERAS];
  const rvdnav_image* images[RVDNAV_CAMERAS] = {NULL, NULL};
  const rvdnav_view_result* views[RVDNAV_CAMERAS] = {NULL, NULL};
  for (int32_t camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
    if (!frame->has[camera]) continue;
    images[camera] = &frame->image[camera];
    views[camera] = &view[camera];
    view[camera].struct_size = sizeof view[camera];
    check(rvdnav_view(context, camera, images[camera], NULL, 0, &view[camera]), "rvdnav_view");
  }
  result->struct_size = sizeof *result;
  check(rvdnav_join(context, images[0], images[1], views[0], views[1], true, result), "rvdnav_join");
}

static uint64_t hash_of(const rvdnav_frame_result* result) {
  uint64_t value = HASH_START;
  for (int camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
    const rvdnav_view_result* view = &result->view[camera];
    value = hash(value, view->lines, sizeof view->lines);
    value = hash(value, view->apexes, sizeof view->apexes);
    value = hash(value, &view->mean_grey, sizeof view->mean_grey);
  }
  value = hash(value, &result->bracket, sizeof result->bracket);
  value = hash(value, result->apexes_W, sizeof result->apexes_W);
  return hash(value, result->matches, result->match_count * sizeof *result->matches);
}

static void put_pose(int64_t stamp_ns, const rvdnav_frame_result* result) {
  const rvdnav_bracket* bracket = &result->bracket;
  put("frame ");
  put_unsigned((uint64_t)stamp_ns);
  if (bracket->found && !bracket->ambiguous) {
    put(" p_W");
    put_vector(bracket->p_W, 3, 6);
    put(" R_W_C");
    put_vector(bracket->R_W_C, 9, 7);
  } else {
    put(bracket->found ? " ambiguous" : " not found");
  }
  put(" hash ");
  put_hash(hash_of(result));
  put_newline();
}

int main(int argc, char** argv) {
  static Sequence sequence;
  static rvdnav_frame_result result;
  rvdnav_context* context = program_start(argc, argv, &sequence);
  for (uint32_t number = 0; number < sequence.frame_count; ++number) {
    Frame frame;
    sequence_read(&sequence, &frame);
    acquire(context, &frame, &result);
    put_pose(frame.stamp_ns, &result);
  }
  put_memory();
  return 0;
}
