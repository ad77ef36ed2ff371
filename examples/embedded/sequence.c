#include "sequence.h"

#include <stddef.h>
#include <string.h>

#include "board.h"
#include "pool.h"
#include "telemetry.h"

static void read(void* data, size_t size) {
  if (!board_read(data, size)) fail("sequence", "it is too short");
}

void sequence_open(const char* path, Sequence* sequence) {
  if (!board_open(path)) fail(path, "cannot be read");
  char magic[8];
  uint32_t header[6];
  read(magic, sizeof magic);
  read(header, sizeof header);
  if (memcmp(magic, "rvdnavsq", sizeof magic) != 0 || header[0] != RVDNAV_ABI_VERSION) fail(path, "no such sequence");
  if (header[2] != sizeof sequence->rig || header[3] != sizeof sequence->target ||
      header[4] != offsetof(rvdnav_config, clock) || header[5] != sizeof sequence->cameras) {
    fail(path, "its structures are others");
  }
  memset(sequence, 0, sizeof *sequence);
  sequence->frame_count = header[1];
  read(&sequence->rig, sizeof sequence->rig);
  read(&sequence->target, sizeof sequence->target);
  read(&sequence->config, offsetof(rvdnav_config, clock));
  read(&sequence->cameras, sizeof sequence->cameras);
  read(&sequence->edges, sizeof sequence->edges);
  sequence->config.struct_size = sizeof sequence->config; /* pointers are of another size elsewhere */
  for (int32_t camera = 0; camera < sequence->rig.camera_count; ++camera) {
    sequence->pixels[camera] = pool_take((size_t)sequence->rig.width * (size_t)sequence->rig.height);
  }
}

void sequence_read(const Sequence* sequence, Frame* frame) {
  struct {
    int64_t stamp_ns;
    uint32_t cameras;
    uint32_t unused;
  } header;
  read(&header, sizeof header);
  frame->stamp_ns = header.stamp_ns;
  const rvdnav_rig* rig = &sequence->rig;
  for (int32_t camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
    frame->has[camera] = camera < rig->camera_count && (header.cameras >> camera & 1) != 0;
    if (!frame->has[camera]) continue;
    read(sequence->pixels[camera], (size_t)rig->width * (size_t)rig->height);
    frame->image[camera] = (rvdnav_image){sequence->pixels[camera], rig->width, rig->height, rig->width};
  }
}
