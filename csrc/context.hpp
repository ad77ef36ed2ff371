// What an rvdnav_context holds: calibration, target, settings, tables and the work memory of both views.
#pragma once

#include "arena.hpp"
#include "bracket_model.hpp"
#include "bracket_propose.hpp"
#include "edge.hpp"
#include "epipolar.hpp"
#include "hough.hpp"
#include "kernels/kernels.hpp"
#include "lens_map.hpp"
#include "lines.hpp"
#include "rvdnav/rvdnav.h"
#include "thin.hpp"
#include "track.hpp"

namespace rvdnav {

// The best proposals that each view carries into the search over both.
constexpr uint32_t kMaxProposals = 32;

// Work memory and the last results of one camera's view.
struct Workspace {
  uint16_t* smooth_row;  // width + 2
  EdgeScratch edge;
  uint8_t* smoothed;      // width * height
  uint32_t* edge_bits;    // edge_row_words(width) * height
  uint32_t* bit_scratch;  // as many
  ThinScratch thin;
  rvdnav_edgel* edgels;   // max_edgels
  uint16_t* accumulator;  // kThetaBins * hough_rho_bins
  TrackScratch track;
  rvdnav_peak* peaks;  // max_peaks
  LineScratch lines;
  rvdnav_segment* segments;  // max_segments
  Line2* segment_lines;      // of them
  rvdnav_bar* bars;          // max_bars
  Proposal* proposals;       // kMaxProposals
  uint32_t edgel_count;
  uint32_t peak_count;
  uint32_t segment_count;
  uint32_t bar_count;
  uint32_t proposal_count;
};

struct Context {
  rvdnav_config config;  // without zeros that stand for what the rig needs
  rvdnav_rig rig;
  rvdnav_target target;
  bool has_target;
  const Kernels* kernels;
  ThresholdCurve threshold;
  BracketModel model;  // meaningful with a target
  int16_t* lens_nodes[RVDNAV_CAMERAS];
  LensMap lens[RVDNAV_CAMERAS];
  double reach;  // of the rectified pixels of both views, from the principal point
  Workspace work[RVDNAV_CAMERAS];
  // used where both views come together
  Proposal* proposals;  // 2 * kMaxProposals
  Disparities disparities;
  MatchScratch match;
};

// Settles config, rig and what follows from them, and gives every array of the context its place; with an arena that
// only counts, the need is what it has used.  config and rig have been validated.
void lay_out(const rvdnav_config& config, const rvdnav_rig& rig, Arena& arena, Context* context);

// Fills the tables of a context that is laid out.  Returns RVDNAV_OK, RVDNAV_ERROR_ISA, or RVDNAV_ERROR_CALIBRATION for
// a lens that can't be mapped.
rvdnav_status build(Context* context);

// The bracket to look for; null: none.  It has been validated.
void set_target(const rvdnav_target* target, Context* context);

}  // namespace rvdnav
