// The parts of the harness, each of which reaches some of the ABI's functions; and a context that several need.
#pragma once

#include "input.hpp"

struct Prepared {
  rvdnav_config config;
  rvdnav_rig rig;
  Memory memory;
  rvdnav_context* context = nullptr;
};

// Settings, rig and target disturbed; false where they are refused or too large for a quick execution.
bool prepare(Input& input, Prepared* prepared);

void fuzz_library(Input& input);
void fuzz_frame(Input& input);
void fuzz_image_stages(Input& input);
void fuzz_line_stages(Input& input);
void fuzz_geometry(Input& input);
void fuzz_surface(Input& input);
void fuzz_images(Input& input);
void fuzz_edge_lines(Input& input);
void fuzz_pose(Input& input);
void fuzz_calibration(Input& input);
void fuzz_measurement(Input& input);
