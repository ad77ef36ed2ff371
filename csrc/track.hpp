// Tracking: the peaks of Hough space inside given windows.
#pragma once

#include "hough.hpp"
#include "integers.hpp"

namespace rvdnav {

// Windows are cut to these half-widths.
constexpr int32_t kTrackMaxHalfRho = 64;    // pixels
constexpr int32_t kTrackMaxHalfTheta = 15;  // degrees

// A peak is the highest within 3 pixels; parallel edges are farther apart.
constexpr int32_t kFlankCells = 6;

// Each window's own accumulator has cells of half a pixel by half a degree, and around the window as many more as that
// and the smoothing along rho and along an edge's shear need.
constexpr int32_t kTrackMinShear = 26;  // cells a row that there is always room for
constexpr int32_t kTrackMaxRows = 4 * kTrackMaxHalfTheta + 2 + 2 * 2;

// Cells a row by which an edge within reach of the principal point (pixels) runs aside.
constexpr int32_t track_shear(double reach) { return larger(kTrackMinShear, static_cast<int32_t>(reach / 57.0)); }

constexpr size_t track_votes(int32_t max_shear) {
  return static_cast<size_t>(4 * kTrackMaxHalfRho + 2 + 2 * (kFlankCells + 2 + 2 * max_shear)) * kTrackMaxRows;
}

struct TrackScratch {
  int32_t max_shear;  // at most track_shear of the view; windows that run aside by more are cut to it
  uint16_t* votes;    // track_votes(max_shear)
};

// The highest peak whose rho and theta lie inside each window, among the edgels beside the expected extent [t_min,
// t_max] (and 10 % of its length + 4 pixels more at both ends), of the window's polarity, and within spread degrees of
// their gradient.  Votes:
// edgels weighted by a triangle of 1.5 pixels to both sides.  A peak with fewer than max(6, a quarter of the length) or
// a mere flank of one outside is none: its votes are 0 and it stands in the window's middle.
void hough_track(const rvdnav_edgel* edgels, uint32_t n, int32_t spread, const rvdnav_window* windows,
                 uint32_t n_windows, const TrackScratch& scratch, rvdnav_peak* out);

}  // namespace rvdnav
