// The header is C++17, and its structures can be copied byte by byte.
#include <type_traits>

#include "rvdnav/rvdnav.h"

static_assert(std::is_trivial_v<rvdnav_config> && std::is_standard_layout_v<rvdnav_config>);
static_assert(std::is_trivial_v<rvdnav_rig> && std::is_standard_layout_v<rvdnav_rig>);
static_assert(std::is_trivial_v<rvdnav_frame_result> && std::is_standard_layout_v<rvdnav_frame_result>);
static_assert(std::is_same_v<decltype(&rvdnav_host_clock), rvdnav_clock>);
