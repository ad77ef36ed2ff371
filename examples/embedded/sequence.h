/* A packed sequence: rig, target, settings and frames in one file, as pack.py writes it.
 *
 * All numbers are little-endian.  Header: the eight characters "rvdnavsq", the version of the C ABI, the numbers of
 * frames, of bytes of rvdnav_rig, of rvdnav_target, of rvdnav_config before its clock and of rvdnav_pose_cameras (six
 * uint32); then these four structures and BracketEdges, as they stand in memory.  A frame: its time stamp in
 * nanoseconds (int64), a bit mask of the cameras that it is of (uint32, 1 left, 2 right), 4 bytes unused, and the
 * pixels of each, row by row. */
#ifndef SEQUENCE_H
#define SEQUENCE_H

#include <stdbool.h>
#include <stdint.h>

#include "rvdnav/rvdnav.h"

/* The bracket's arrays in an rvdnav_edge_model. */
typedef struct BracketEdges {
  double points[RVDNAV_APEXES][3];
  double side_normals[RVDNAV_EDGES][3];
  int32_t ends[RVDNAV_EDGES][2];
} BracketEdges;

typedef struct Sequence {
  uint32_t frame_count;
  rvdnav_rig rig;
  rvdnav_target target;
  rvdnav_config config; /* without a clock */
  rvdnav_pose_cameras cameras;
  BracketEdges edges;
  uint8_t* pixels[RVDNAV_CAMERAS]; /* of the frame that was read last */
} Sequence;

typedef struct Frame {
  int64_t stamp_ns;
  bool has[RVDNAV_CAMERAS];
  rvdnav_image image[RVDNAV_CAMERAS];
} Frame;

/* Reads the header and takes memory for the pixels of one frame from the pool; ends the program if it cannot. */
void sequence_open(const char* path, Sequence* sequence);
/* The next frame; its pixels stay until the frame after it is read. */
void sequence_read(const Sequence* sequence, Frame* frame);

#endif
