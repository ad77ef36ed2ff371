/* The header is C99, and its layout is what the text says. */
#include "rvdnav/rvdnav.h"

/* An array of negative size stops the compiler where the condition is false. */
#define CHECK_AT_COMPILE_TIME(name, condition) typedef char name[(condition) ? 1 : -1]

CHECK_AT_COMPILE_TIME(edgel_is_packed, sizeof(rvdnav_edgel) == 12);
CHECK_AT_COMPILE_TIME(lines_of_all_edges,
                      sizeof(((rvdnav_view_result*)0)->lines) == RVDNAV_EDGES * sizeof(rvdnav_line));
CHECK_AT_COMPILE_TIME(all_apexes, sizeof(((rvdnav_view_result*)0)->apexes) == RVDNAV_APEXES * 2 * sizeof(double));
CHECK_AT_COMPILE_TIME(all_view_stages, sizeof(((rvdnav_view_result*)0)->stage_ns) == RVDNAV_STAGES * sizeof(uint64_t));
CHECK_AT_COMPILE_TIME(all_frame_stages,
                      sizeof(((rvdnav_frame_result*)0)->stage_ns) == RVDNAV_STAGES * sizeof(uint64_t));
CHECK_AT_COMPILE_TIME(all_matches,
                      sizeof(((rvdnav_frame_result*)0)->matches) == RVDNAV_MAX_MATCHES * sizeof(rvdnav_match));
CHECK_AT_COMPILE_TIME(both_views,
                      sizeof(((rvdnav_frame_result*)0)->view) == RVDNAV_CAMERAS * sizeof(rvdnav_view_result));

uint32_t rvdnav_header_is_c99(void);
uint32_t rvdnav_header_is_c99(void) { return rvdnav_abi_version(); }
