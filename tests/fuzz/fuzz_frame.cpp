// The frame, with and without windows: view by view, and by the two threads of the host's runner.
#include <algorithm>

#include "parts.hpp"

namespace {

struct Views {
  const rvdnav_image* image[RVDNAV_CAMERAS] = {};
  std::vector<rvdnav_window> windows;
};

void one_by_one(Input& input, const Prepared& prepared, const Views& views, uint32_t window_count) {
  rvdnav_view_result results[RVDNAV_CAMERAS] = {};
  for (int32_t camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
    if (views.image[camera] == nullptr) continue;
    results[camera].struct_size = sizeof(results[camera]);
    const rvdnav_status status = rvdnav_view(prepared.context, camera, views.image[camera], views.windows.data(),
                                             window_count, &results[camera]);
    require(status == RVDNAV_OK || window_count > 0);
    if (status != RVDNAV_OK) return;
    if (input.one_in(8)) disturb_sized(input, 4, &results[camera]);
  }
  rvdnav_frame_result frame = {};
  frame.struct_size = sizeof(frame);
  require(
      rvdnav_join(prepared.context, views.image[0], views.image[1], views.image[0] != nullptr ? &results[0] : nullptr,
                  views.image[1] != nullptr ? &results[1] : nullptr, window_count == 0 ? 1 : 0, &frame) == RVDNAV_OK);
}

void by_threads(Input&, const Prepared& prepared, const Views& views, uint32_t window_count) {
  rvdnav_runner* runner = nullptr;
  require(rvdnav_runner_create(&runner) == RVDNAV_OK);
  rvdnav_frame_result frame = {};
  frame.struct_size = sizeof(frame);
  const rvdnav_status status =
      rvdnav_runner_process(runner, prepared.context, views.image[0], views.image[1], views.windows.data(),
                            window_count, views.windows.data(), window_count, &frame);
  rvdnav_runner_destroy(runner);
  require(status == RVDNAV_OK || window_count > 0);
}

}  // namespace

void fuzz_frame(Input& input) {
  Prepared prepared;
  if (!prepare(input, &prepared)) return;
  const Picture left(input, prepared.rig), right(input, prepared.rig);
  Views views;
  const uint32_t missing = input.below(8);
  if (missing != 6) views.image[0] = left.image();
  if (prepared.rig.camera_count == RVDNAV_CAMERAS && missing != 7) views.image[1] = right.image();
  if (views.image[0] == nullptr && views.image[1] == nullptr) return;
  views.windows.resize(input.one_in(16) ? RVDNAV_EDGES + 1 : 2);  // each takes a while
  for (size_t i = 0; i < views.windows.size(); ++i) {
    const auto edge = static_cast<int32_t>(i);
    views.windows[i] = {edge, 0, -12.0, edge % 2 == 0 ? 0.0 : 1.57, 3.0, 0.1, -10.0, 10.0};
  }
  disturb_all(input, 4, &views.windows);
  const auto run = input.one_in(32) ? by_threads : one_by_one;
  for (const size_t count : {size_t{0}, views.windows.size()})
    run(input, prepared, views, static_cast<uint32_t>(count));
}
