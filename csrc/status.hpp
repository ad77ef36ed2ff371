// How a status is handed on.
#pragma once

#include "rvdnav/rvdnav.h"

// Leaves the function with the status unless it is RVDNAV_OK.
#define RVDNAV_TRY(expression)                      \
  do {                                              \
    const rvdnav_status try_status = (expression);  \
    if (try_status != RVDNAV_OK) return try_status; \
  } while (false)
