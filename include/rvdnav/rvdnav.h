/* rvdnav: stereo-vision navigation for spacecraft rendezvous and docking.
 *
 * The C ABI: the only contract between the C++ core and everyone else.
 *
 * Conventions
 *   Frames     W  world: origin in the right camera's centre, z_W from the right to the left camera's centre, x_W forward,
 *                 y_W down.  C  capture frame of the target.  T_W_C maps coordinates in C to coordinates in W.
 *   Rectified  Both cameras share the axes x = -z_W, y = y_W, z = x_W, one focal length and the principal point as the
 *                 origin of pixel coordinates, so a world point has the same y in both views.  Raw pixel (0, 0) is the
 *                 centre of the top-left pixel.
 *   Lines      x cos(theta) + y sin(theta) = rho in rectified pixels, theta in [-45, 135) degrees.  A position along a
 *                 line is t = -x sin(theta) + y cos(theta).
 *   Units      metres, radians, pixels, unless a name says otherwise.  A name ending in _qN counts units of 2^-N.
 *
 * Rules
 *   Every fallible call returns a status: RVDNAV_OK or a negative code that is never renumbered.  After a failure the
 *   outputs are unspecified but no memory outside them has been touched.  The library never allocates, keeps no global
 *   state, reads no clock, file or environment (the host part at the end of this file excepted) and throws nothing.
 *   Structures that may grow begin with struct_size: set it to sizeof the structure before the call.
 *   Camera index 0 is the left camera, 1 the right one.  Calls on one context may run at the same time when their
 *   camera indices differ; rvdnav_join uses both.
 */
#ifndef RVDNAV_RVDNAV_H
#define RVDNAV_RVDNAV_H

#ifndef RVDNAV_CDEF /* the binding reads the declarations alone */
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif
#if defined(__GNUC__)
#define RVDNAV_API __attribute__((visibility("default")))
#else
#define RVDNAV_API
#endif
#else
#define RVDNAV_API
#endif

enum {
  RVDNAV_ABI_VERSION = 3,
  RVDNAV_CAMERAS = 2,
  RVDNAV_BARS = 4,              /* l1, l2, l3, l4 */
  RVDNAV_EDGES = 8,             /* l1 outer, l1 inner, l2 outer, ... l4 inner */
  RVDNAV_APEXES = 8,            /* P1..P4 (outer), Q1..Q4 (inner) */
  RVDNAV_MAX_MATCHES = 64,      /* correlated points a frame */
  RVDNAV_MAX_POSE_EDGES = 256,  /* edges of a target whose pose is refined */
  RVDNAV_MAX_POSE_LINES = 512,  /* lines in both views of them */
  RVDNAV_MAX_PARAMETERS = 2048, /* beside the pose: each edge's ends and the edge, calibration, steps, motion */
  RVDNAV_MAX_GROUPS = 8,        /* of these */
  RVDNAV_MAX_POINTS = 512,      /* that the edges of a target end in */
  RVDNAV_MAX_FACES = 256,       /* of a target */
  RVDNAV_MAX_CORNERS = 256,     /* of a face */
  RVDNAV_DIRECTION_LEVELS = 256 /* quantised gradient directions in a full turn */
};

typedef int32_t rvdnav_status;
enum {
  RVDNAV_OK = 0,
  RVDNAV_ERROR_NULL = -1,        /* a required pointer is null */
  RVDNAV_ERROR_STRUCT_SIZE = -2, /* struct_size is not one this library knows */
  RVDNAV_ERROR_ARGUMENT = -3,    /* a value is out of its range */
  RVDNAV_ERROR_MEMORY = -4,      /* the memory given is too small or misaligned */
  RVDNAV_ERROR_CONTEXT = -5,     /* not an initialised context of this version */
  RVDNAV_ERROR_IMAGE = -6,       /* the image's size or stride does not fit the context */
  RVDNAV_ERROR_CAPACITY = -7,    /* an output array is too small; its count says how much is needed where it is known */
  RVDNAV_ERROR_CALIBRATION = -8, /* a camera or rig parameter is not finite or not usable */
  RVDNAV_ERROR_TARGET = -9,      /* the bracket is degenerate */
  RVDNAV_ERROR_ISA = -10,        /* this processor or build lacks the instruction set asked for */
  RVDNAV_ERROR_THREAD = -11,     /* the host could not start its worker thread */
  RVDNAV_ERROR_UNDETERMINED = -12, /* the measurements do not determine the pose */
  RVDNAV_ERROR_BEHIND = -13,       /* a point of the target is not in front of its camera */
  RVDNAV_ERROR_NO_AGREEMENT = -14  /* no measurement agrees with the pose */
};

/* Instruction set of the row kernels. */
enum { RVDNAV_ISA_AUTO = 0, RVDNAV_ISA_SCALAR = 1, RVDNAV_ISA_AVX2 = 2, RVDNAV_ISA_NEON = 3, RVDNAV_ISA_SSE2 = 4 };

/* The stages of a frame, in the order of the data; indices of stage_ns. */
enum {
  RVDNAV_STAGE_SMOOTH = 0,
  RVDNAV_STAGE_EDGES = 1,
  RVDNAV_STAGE_THIN = 2,
  RVDNAV_STAGE_RECTIFY = 3,
  RVDNAV_STAGE_HOUGH = 4,
  RVDNAV_STAGE_LINES = 5,
  RVDNAV_STAGE_BRACKET = 6,
  RVDNAV_STAGE_REFIT = 7,
  RVDNAV_STAGE_EPIPOLAR = 8,
  RVDNAV_STAGE_TRIANGULATE = 9,
  RVDNAV_STAGES = 10
};

/* Work limits that a frame ran into (bit mask): the result is what could be done within them. */
enum {
  RVDNAV_LIMIT_EDGELS = 1,
  RVDNAV_LIMIT_PEAKS = 2,
  RVDNAV_LIMIT_SEGMENTS = 4,
  RVDNAV_LIMIT_BARS = 8,
  RVDNAV_LIMIT_HYPOTHESES = 16,
  RVDNAV_LIMIT_RHO = 32 /* hough_rho_bins was set to fewer than the image needs: lines farther out are not seen */
};

typedef struct rvdnav_context rvdnav_context;

/* Returns nanoseconds from any fixed start; user is passed through. */
typedef uint64_t (*rvdnav_clock)(void* user);

/* An 8-bit grey image that the caller keeps alive during the call; stride in bytes, at least width. */
typedef struct rvdnav_image {
  const uint8_t* data;
  int32_t width;
  int32_t height;
  int32_t stride;
} rvdnav_image;

/* In brackets: the range of a value, ends included.  NaN is outside every range; whatever is outside is refused. */

/* Pinhole camera with radial and tangential distortion (Brown; OpenCV's k1 k2 p1 p2).  A pixel beyond the fold of the
 * distortion has no ray: nothing is measured there. */
typedef struct rvdnav_camera {
  double fx, fy;        /* pixels [1, 1e6] */
  double cx, cy;        /* pixels [-16384, 16384] */
  double k1, k2;        /* [-1e9, 1e9] */
  double p1, p2;        /* [-1e3, 1e3] */
  double R_rect_cam[9]; /* row-major rotation, camera to rectified axes */
} rvdnav_camera;

/* Every rectified pixel lies within 8191 pixels of the principal point and, in x and in y, within 4095 of its raw one
 * (both from the middle of the image). */
typedef struct rvdnav_rig {
  uint32_t struct_size;
  int32_t width;        /* of both images, pixels [16, 4096] */
  int32_t height;       /* [16, 4096] */
  int32_t camera_count; /* 1 (left only) or 2 */
  double focal_rect;    /* common focal length of the rectified views, pixels [1, 1e6] */
  double baseline;      /* metres [1e-6, 1e3]; 0 with one camera */
  rvdnav_camera camera[2];
} rvdnav_rig;

/* The four-bar bracket: front-face apexes in the capture frame C, metres [-1e3, 1e3].  Both quadrilaterals are flat,
 * the inner one inside the outer one, edges at least 1 mm long. */
typedef struct rvdnav_target {
  uint32_t struct_size;
  uint32_t reserved;
  double outer[4][3]; /* P1..P4 */
  double inner[4][3]; /* Q1..Q4 */
  double thickness;   /* of the bars towards +x_C [0, 1e3] */
} rvdnav_target;

/* Settings; rvdnav_config_default fills all of them, rvdnav_config_range tells a field's range. */
typedef struct rvdnav_config {
  uint32_t struct_size;
  int32_t isa; /* RVDNAV_ISA_... */
  /* adaptive Sobel: threshold over the local mean m is max(floor, weber * m), with slope weber/4 above the knee */
  int32_t edge_floor;    /* grey levels of step [1, 255] */
  int32_t edge_weber_q8; /* fraction of the local mean [0, 255] */
  int32_t edge_knee;     /* grey level [0, 255] */
  int32_t edge_min_run;  /* shortest connected edge kept, pixels [0, 64] */
  /* Hough space: 180 bins of one degree over theta, rho_bins of one pixel over rho */
  int32_t hough_rho_bins; /* [0, 32768]; 0: as many as the rectified images need */
  int32_t hough_spread;   /* half-width of a vote around the gradient's direction, bins [0, 45] */
  int32_t peak_min_votes; /* [1, 65535] */
  /* lines and bars */
  int32_t segment_min_length; /* pixels [4, 4096] */
  int32_t segment_max_gap;    /* pixels [0, 4096] */
  /* work limits */
  int32_t max_edgels;     /* [0, 2^22]; 0: a sixteenth of the pixels, at least 65536 */
  int32_t max_peaks;      /* [1, 2^14] */
  int32_t max_segments;   /* [1, 2^14] */
  int32_t max_bars;       /* [1, 2^14] */
  int32_t max_hypotheses; /* [1, 2^20] */
  /* epipolar correlation */
  int32_t match_half_window;     /* pixels [1, 10] */
  int32_t match_row_tolerance;   /* pixels [0, 4] */
  int32_t match_min_score_q8;    /* ZNCC, 256 = 1 [0, 256] */
  int32_t match_uniqueness_q8;   /* best rival's score must stay below this fraction of the best [0, 256] */
  int32_t match_max_gradient_q8; /* limit of the disparity gradient between neighbours [1, 65536] */
  int32_t match_consistency_q8;  /* left-right disagreement, pixels [0, 65536] */
  double range_min;              /* range gate, metres [1e-3, 1e4] */
  double range_max;              /* [1e-3, 1e4], above range_min */
  double blur_sigma;             /* of an edge in the image, pixels: lens and pixel together [0.1, 10] */
  rvdnav_clock clock;            /* optional: fills stage_ns */
  void* clock_user;
} rvdnav_config;

/* What tells an image of two fields, whose rows were exposed alternately at two times, from others. */
typedef struct rvdnav_fields {
  uint32_t struct_size;
  uint32_t tiles;         /* of 32 columns and 32 rows, that show edges */
  uint32_t combed;        /* of them: the odd rows lie displaced along the rows against the even ones, all alike */
  uint32_t row_pairs;     /* an even row with the next one; the last pair left out */
  uint32_t changed_pairs; /* of them: the next pair begins otherwise than this one ends, somewhere by 8 or more */
  uint32_t equal_pairs;   /* of those: there the pair's own rows differ by less than a quarter of that */
} rvdnav_fields;

/* A thinned edge pixel in rectified coordinates. */
typedef struct rvdnav_edgel {
  int32_t x_q5;
  int32_t y_q5;
  uint8_t direction; /* of the gradient (towards brighter), 256 to the turn, from +x towards +y, rectified */
  uint8_t reserved[3];
} rvdnav_edgel;

/* A local maximum of Hough space. */
typedef struct rvdnav_peak {
  int32_t rho_q8;   /* pixels [-16384, 16384] */
  int32_t theta_q8; /* degrees [-360, 360] */
  uint32_t votes;   /* 0: no peak (rvdnav_hough_track only) */
} rvdnav_peak;

/* A straight run of edgels along a line. */
typedef struct rvdnav_segment {
  double rho;          /* [-16384, 16384] */
  double theta;        /* a full turn to both sides at most */
  double t_min, t_max; /* its ends along the line [-16384, 16384] */
  int32_t polarity;    /* +1: brighter towards growing rho, -1: darker */
  uint32_t support;    /* edgels on it */
  double rms;          /* of the edgels across it, pixels */
} rvdnav_segment;

/* Two near-parallel segments with a small distance: the projection of a bar. */
typedef struct rvdnav_bar {
  int32_t segment[2];  /* indices; the second has the larger rho */
  double rho, theta;   /* centre line */
  double width;        /* pixels */
  double t_min, t_max; /* where both edges are seen or bridged */
} rvdnav_bar;

/* Where one of the bracket's edges is expected in Hough space (a prior for tracking). */
typedef struct rvdnav_window {
  int32_t edge;          /* 0 .. RVDNAV_EDGES-1 */
  int32_t polarity;      /* +1: brighter towards growing rho, -1: darker, 0: either */
  double rho, theta;
  double half_rho, half_theta;
  double t_min, t_max;   /* the edge's extent along the line */
} rvdnav_window;

/* One of the bracket's edges as measured in one view. */
typedef struct rvdnav_line {
  int32_t found;       /* a peak stood in its window */
  int32_t refitted;    /* the grey profile gave a sub-pixel line */
  uint32_t votes;      /* of the peak */
  uint32_t samples;    /* profile samples behind the sub-pixel line */
  double rho, theta;   /* sub-pixel where refitted, else the peak's */
  double covariance[4];/* of (rho, theta), row-major; 0 unless refitted */
  double t_min, t_max;
  double rms;          /* of the samples across the line, pixels */
} rvdnav_line;

/* A straight model edge to be measured in the raw grey values, given in rectified coordinates. */
typedef struct rvdnav_model_edge {
  double x0, y0, x1, y1;
  double face;      /* width, pixels, of the even face that it bounds: positive where that lies towards the normal
                       (-(y1-y0), x1-x0), negative where away from it; 0: unknown */
  double blur;      /* standard deviation of its step's blur, pixels [0, 10]; 0: that of the call */
  int32_t polarity; /* +1: brighter towards the normal, -1: darker, 0: either */
  int32_t reserved;
} rvdnav_model_edge;

/* What a camera sees of one of the target's edges, to be measured where a pose puts it. */
typedef struct rvdnav_seen_edge {
  double ends[2][3]; /* in the rectified axes from the camera's centre, metres; in front of it */
  double offset[2];  /* by which the ends lie beside their projections, pixels, towards the normal (-(y1-y0), x1-x0) */
  double face;       /* as of rvdnav_model_edge; unknown beyond 1e4 */
  double blur;       /* standard deviation of its step's blur, pixels [0, 10]; 0: that of the configuration */
  int32_t camera;
  int32_t polarity;  /* +1: brighter towards the normal, -1: darker, 0: either */
} rvdnav_seen_edge;

/* What of a seen edge could be measured. */
typedef struct rvdnav_edge_coverage {
  int32_t placed;   /* it was long enough, with both ends within 1e4 pixels of the principal point */
  int32_t profiles; /* across it, with their middles on the image */
} rvdnav_edge_coverage;

/* One profile across a model edge. */
typedef struct rvdnav_edge_sample {
  int32_t edge;    /* index into the model edges */
  int32_t polarity;/* sign of the step found along the normal */
  double fraction; /* position along the edge, 0 at its first end, 1 at its second */
  double x, y;     /* where the step was found, rectified pixels */
  double nx, ny;   /* unit normal, rectified */
  double offset;   /* from the model edge along the normal, pixels */
  double contrast; /* grey levels, positive */
  double sigma;    /* standard deviation of offset from the profile's own noise, pixels */
  double blur;     /* of the step in the image, pixels: lens and pixel together */
  double slope_shift; /* by how much offset changes if the grey beside the step may slope, pixels; 0 without a face */
  double slope;    /* the steeper of its two slopes then, parts of the contrast a pixel */
} rvdnav_edge_sample;

/* What the calibration's errors do to the rectified views: derivatives with respect to its parameters, or to
 * combinations of them. */
typedef struct rvdnav_calibration_effect {
  uint32_t struct_size;
  uint32_t parameters;   /* [0, 64] */
  const double* shift;   /* of the rectified coordinates, pixels, of a raw pixel: for each camera 12 x 12 x 2 x parameters
                            coefficients of products of Chebyshev polynomials of degrees 0..11 of the column and of the
                            row, both scaled so that the image's last pixels lie at -1 and 1; x, then y */
  const double* focal;   /* parameters: of the rectified focal length, pixels */
  const double* centers; /* for each camera 3 x parameters: of its centre, rectified axes, metres */
} rvdnav_calibration_effect;

/* A line that was measured in a view, and the ends of its edge where a pose has them. */
typedef struct rvdnav_measured_line {
  double rho, theta;
  double ends[2][3];     /* in the rectified axes from the camera's centre, metres; in front of it */
  int32_t camera;
  int32_t reserved;
} rvdnav_measured_line;

/* A point of the left view found in the right view along its epipolar row. */
typedef struct rvdnav_match {
  double x, y;       /* left, rectified */
  double disparity;  /* x_left - x_right, pixels, sub-pixel */
  double score;      /* ZNCC, -1..1 */
  double p_W[3];     /* triangulated, metres */
  int32_t bar;       /* 0 .. RVDNAV_BARS-1 or -1 */
  int32_t accepted;  /* passed every limit */
} rvdnav_match;

/* A point of the visible surface: a zero crossing of the Laplacian of Gaussian, matched along its row. */
typedef struct rvdnav_surface_point {
  int32_t x_q8, y_q8;      /* left, rectified */
  int32_t disparity_q8;    /* x_left - x_right, pixels */
  int32_t score_q15;       /* ZNCC of the grey windows around it */
  int32_t grey;            /* of the left view there, 0..255 */
  int32_t reserved;
  double sigma_disparity;  /* standard deviation from the match itself, pixels */
  double p_W[3];           /* metres */
  double sigma;            /* standard deviation of p_W along the left camera's ray, metres; across it there is next to none */
} rvdnav_surface_point;

/* A place on one of a target's edges as found in one view. */
typedef struct rvdnav_edge_point {
  int32_t camera;
  int32_t edge;    /* [0, RVDNAV_MAX_POSE_EDGES) */
  double x, y;     /* rectified pixels */
  double nx, ny;   /* unit normal of the edge; those of an edge in a view are equal up to small angles */
  double sigma;    /* standard deviation along it, pixels */
} rvdnav_edge_point;

/* The line through an edge's places in one view. */
typedef struct rvdnav_edge_line {
  int32_t camera;
  int32_t edge;
  double rho, theta;    /* theta is that of the places' normals, in any turn */
  double covariance[4]; /* of (rho, theta), row-major, from the scatter about the line */
  double rms;           /* of the places that agree, pixels */
} rvdnav_edge_line;

/* The rectified cameras in W. */
typedef struct rvdnav_pose_cameras {
  double focal;        /* pixels */
  double centre[2][3]; /* metres */
  double R_rect_W[9];  /* row-major rotation from W to the rectified axes */
} rvdnav_pose_cameras;

/* A measured line of a known edge. */
typedef struct rvdnav_pose_line {
  int32_t camera;
  int32_t reserved;
  double from_C[3], to_C[3]; /* ends of what was seen of the edge, metres */
  double rho, theta;
  double covariance[4];      /* of (rho, theta), row-major */
  double shift_sigma;        /* standard deviation of a displacement of the whole line that its fit knows nothing of, pixels */
} rvdnav_pose_line;

/* Parameters whose standard deviations were stated together. */
typedef struct rvdnav_parameter_group {
  uint32_t size;
  int32_t doubtful; /* the statement may be wrong by the largest scale */
  double scale;   /* of what was stated, above 0 */
  double weight;  /* how many independent errors the statement is worth against those that the lines show; infinite: it stands */
  double largest; /* scale */
} rvdnav_parameter_group;

enum { RVDNAV_LOSS_TUKEY = 0, RVDNAV_LOSS_HUBER = 1 };

/* Lines and what is known beside them.  n lines; p parameters z of errors that lines share, each of unit standard
 * deviation as stated: to first order the residuals are r(pose) + G z. */
typedef struct rvdnav_pose_problem {
  uint32_t struct_size;
  uint32_t line_count;         /* [0, RVDNAV_MAX_POSE_LINES] */
  const rvdnav_pose_line* lines;
  rvdnav_pose_cameras cameras;
  double R_W_C[9];             /* start */
  double p_W[3];
  int32_t loss;                /* RVDNAV_LOSS_... */
  int32_t near_minimum;        /* the start is near it, so outliers are told by it at once */
  double k;                    /* the loss's bound in standard deviations; 0: 95 % efficient at a normal distribution */
  int32_t shown;               /* what displaces the ends, and the groups' scales, are what the lines show */
  int32_t reserved;
  double endpoint_sigma;       /* else: standard deviation of what displaces each end by itself, pixels, above 0 */
  uint32_t parameter_count;    /* [0, RVDNAV_MAX_PARAMETERS] */
  uint32_t group_count;        /* [0, RVDNAV_MAX_GROUPS] */
  rvdnav_parameter_group groups[8]; /* RVDNAV_MAX_GROUPS; in the order of the parameters */
  const double* derivative;    /* G (n, 2, p), pixels */
  const double* information;   /* (p, p), symmetric: what earlier frames told */
  const double* vector;        /* (p): that times the mean */
} rvdnav_pose_problem;

/* A refined pose and how far to trust it.  The arrays are the caller's; null where they are not wanted. */
typedef struct rvdnav_refined_pose {
  uint32_t struct_size;
  int32_t converged;
  uint32_t iterations;
  uint32_t reserved;
  double R_W_C[9];
  double p_W[3];
  double covariance[36];    /* (position, rotation) in W: p + dp, exp([dtheta]x) R */
  double sigma0;            /* a-posteriori standard deviation of unit weight */
  double displacement;      /* standard deviation of what displaces each line beyond its covariance, pixels */
  double scales[8];         /* of the groups */
  double* residuals;        /* (n, 2), pixels */
  double* weights;          /* (n), [0, 1] */
  double* gain;             /* (6, n, 2): a small change dr of the residuals moves the pose by -gain dr */
  double* z;                /* (p) */
  double* joint_covariance; /* (6 + p, 6 + p) of pose and parameters */
  double* told_information; /* (6 + p, 6 + p) by the lines alone, at the estimate */
  double* told_gradient;    /* (6 + p); with told_information */
} rvdnav_refined_pose;

/* A target's straight edges in C, and what is known of them.  A bracket's are the front edges of its four bars: l1 outer,
 * l1 inner, l2 outer, ... l4 inner. */
typedef struct rvdnav_edge_model {
  uint32_t struct_size;
  uint32_t point_count;        /* [2, RVDNAV_MAX_POINTS] */
  uint32_t edge_count;         /* [1, RVDNAV_MAX_POSE_EDGES]; RVDNAV_EDGES of a bracket */
  uint32_t face_count;         /* [0, RVDNAV_MAX_FACES]; 0: nothing hides the edges */
  uint32_t corner_count;       /* [3, RVDNAV_MAX_CORNERS] of every face, its last corner repeated where it has fewer */
  int32_t bracket;             /* whether it is one */
  double thickness;            /* of a bracket's bars towards +x_C, metres */
  double touch;                /* distance below which a place lies on a face, metres */
  const double* points;        /* (point_count, 3) metres */
  const double* point_sigmas;  /* (point_count): standard deviation of each coordinate, metres; 0: exact */
  const int32_t* ends;         /* (edge_count, 2): the points that an edge runs from and to */
  const double* side_normals;  /* (edge_count, 3): of a bracket's side faces, unit, outward; else not looked at */
  /* The planar faces: */
  const double* face_normals;  /* (face_count, 3): unit, outward */
  const double* face_origins;  /* (face_count, 3): a corner, metres */
  const double* face_axes;     /* (face_count, 2, 3): orthonormal, in the plane */
  const double* face_corners;  /* (face_count, corner_count, 2): along these from the origin, metres */
  const uint8_t* adjoining;    /* (edge_count, face_count): 1 where the edge lies on the face */
} rvdnav_edge_model;

/* How fast a target moves while a rolling shutter exposes the rows. */
typedef struct rvdnav_motion {
  double row_seconds;      /* from the exposure of a row to that of the next one; 0: all at once, and the rest is void */
  double velocity[6];      /* of the target's origin, m/s, and angular, rad/s, in W */
  double covariance[36];   /* of these */
} rvdnav_motion;

/* What there is to measure a target's pose by, near one that is good to two or three pixels.
 * The lasting errors are q parameters, each of unit standard deviation as stated: three coordinates of each point that is
 * not exact, then the calibration's. */
typedef struct rvdnav_measurement_problem {
  uint32_t struct_size;
  uint32_t lasting_count;        /* q, as the model and the effect have it */
  const rvdnav_edge_model* model;
  rvdnav_pose_cameras cameras;
  double R_W_C[9];               /* start */
  double p_W[3];
  const int32_t* polarity;       /* (cameras, edges): of the steps as last seen, +1 brighter towards the normal
                                    (-(y1-y0), x1-x0), -1 darker, 0 unknown */
  const rvdnav_calibration_effect* effect; /* null: the calibration is exact */
  double scales[5];              /* of what was stated of points, calibration, steps, edges and motion */
  const double* information;     /* (q, q): what earlier frames told of the lasting errors */
  const double* vector;          /* (q): that times the mean */
  const double* start;           /* (q): the lasting errors that the start was found with */
  rvdnav_motion motion;
} rvdnav_measurement_problem;

/* What a view shows of an edge. */
typedef struct rvdnav_edge_evidence {
  int32_t attempted;     /* profiles on the image */
  int32_t agreed;        /* of them: with the pose */
  int32_t polarity;      /* of those: +1 brighter towards the normal, -1 darker, 0 neither for the most part */
  int32_t reserved;
  double blur;           /* standard deviation of the steps' blur, pixels */
  double back_coverage;  /* part of the profiles that agree with the back edge of a bracket's side face in sight, where
                            the front edge agrees on less than half of its length */
} rvdnav_edge_evidence;

/* A measured pose with what speaks for it, in arrays of the caller's; n lines, of as many edges in as many views at most,
 * and p parameters: the lasting ones, one a camera (displaced steps), one an edge (displaced in all views alike) and, with
 * a rolling shutter, six (velocity). */
typedef struct rvdnav_measurement {
  uint32_t struct_size;
  uint32_t line_count;            /* n */
  int32_t settled;                /* the last round changed the pose by less than its standard deviation */
  int32_t reserved;
  rvdnav_refined_pose pose;       /* its arrays are required */
  double own_covariance[36];      /* of what errs in this frame alone, and what it changed of the lasting errors */
  rvdnav_edge_evidence* evidence; /* (cameras, edges) */
  rvdnav_pose_line* lines;        /* (cameras x edges), n used */
  int32_t* line_edges;            /* the same */
  double* derivative;             /* (cameras x edges, 2, p), the first n used: of the lines' residuals, pixels */
  double* taught_information;     /* (q, q): what the frame tells of the lasting errors by itself */
  double* taught_vector;          /* (q) */
} rvdnav_measurement;

/* What one view gives. */
typedef struct rvdnav_view_result {
  uint32_t struct_size;
  uint32_t limits;          /* RVDNAV_LIMIT_... */
  uint32_t edge_count;      /* edge pixels after thinning */
  uint32_t peak_count;
  uint32_t segment_count;
  uint32_t bar_count;
  uint32_t line_mask;       /* bit e: lines[e].found */
  uint32_t saturated_permille;
  double mean_grey;
  rvdnav_line lines[8];     /* RVDNAV_EDGES */
  double apexes[8][2];      /* RVDNAV_APEXES: intersections of the lines, rectified pixels */
  uint32_t apex_mask;       /* bit a: apexes[a] is measured */
  uint32_t reserved;
  uint64_t stage_ns[10];    /* RVDNAV_STAGES; zeros without a clock */
} rvdnav_view_result;

/* The bracket as acquired without a prior. */
typedef struct rvdnav_bracket {
  int32_t found;
  int32_t ambiguous;         /* a different pose explains the images about as well */
  double score;              /* supported fraction of the bracket's edges over both views, 0..1 */
  double runner_up;          /* of the best clearly different pose */
  double R_W_C[9];           /* row-major */
  double p_W[3];
  uint32_t hypotheses;       /* tested */
  uint32_t reserved;
} rvdnav_bracket;

/* What the stereo frame gives. */
typedef struct rvdnav_frame_result {
  uint32_t struct_size;
  uint32_t limits;
  rvdnav_view_result view[2];
  rvdnav_bracket bracket;        /* filled when no windows were given */
  double apexes_W[8][3];         /* triangulated, metres */
  uint32_t apex_mask;
  uint32_t match_count;
  rvdnav_match matches[64];      /* RVDNAV_MAX_MATCHES */
  uint64_t stage_ns[10];         /* of the join alone */
} rvdnav_frame_result;

/* ---- library ---- */
RVDNAV_API uint32_t rvdnav_abi_version(void);
RVDNAV_API const char* rvdnav_status_text(rvdnav_status status);
/* sizeof of a structure of this library by name ("rvdnav_rig"), 0 if unknown: lets a binding check its layout. */
RVDNAV_API uint32_t rvdnav_struct_size(const char* name);

/* ---- context ---- */
RVDNAV_API rvdnav_status rvdnav_config_default(rvdnav_config* config);
/* The range of a number of rvdnav_config by its name, ends included; RVDNAV_ERROR_ARGUMENT for another name. */
RVDNAV_API rvdnav_status rvdnav_config_range(const char* name, double* low, double* high);
RVDNAV_API rvdnav_status rvdnav_context_size(const rvdnav_config* config, const rvdnav_rig* rig, size_t* size);
/* memory: aligned to 64 bytes, at least the size asked for; the context lives in it until the caller frees it. */
RVDNAV_API rvdnav_status rvdnav_context_init(void* memory, size_t size, const rvdnav_config* config, const rvdnav_rig* rig,
                                             const rvdnav_target* target, rvdnav_context** context);
/* Another target, or none (null), in place.  No other call on the context may run meanwhile. */
RVDNAV_API rvdnav_status rvdnav_context_set_target(rvdnav_context* context, const rvdnav_target* target);
/* The settings in use: with numbers in place of zeros that stand for what the rig needs. */
RVDNAV_API rvdnav_status rvdnav_context_config(const rvdnav_context* context, rvdnav_config* config);
RVDNAV_API int32_t rvdnav_context_isa(const rvdnav_context* context);

/* ---- the frame ---- */
/* One camera's view: every stage up to the lines.  At most RVDNAV_EDGES windows.  No windows: acquisition, whose segments
 * and bars stay in the context for the rvdnav_join of the same frame. */
RVDNAV_API rvdnav_status rvdnav_view(rvdnav_context* context, int32_t camera, const rvdnav_image* image,
                                     const rvdnav_window* windows, uint32_t window_count, rvdnav_view_result* result);
/* Both views of a frame together: bracket (when acquiring), lines, apexes, correlation, triangulation.  A view result
 * of a camera without image is given as null (its image too). */
RVDNAV_API rvdnav_status rvdnav_join(rvdnav_context* context, const rvdnav_image* left, const rvdnav_image* right,
                                     const rvdnav_view_result* left_view, const rvdnav_view_result* right_view,
                                     int32_t acquire, rvdnav_frame_result* result);

/* ---- images as they come: of up to 4096x4096 pixels, without a context ---- */
/* A number that another image has as good as never, however little it differs. */
RVDNAV_API rvdnav_status rvdnav_image_digest(const rvdnav_image* image, uint64_t* digest);
/* Twice the median of |(1 -2 1)^T (1 -2 1)| over every third row, of even many values the sum of the two in the middle:
 * 6 * 0.6745 times the standard deviation of white noise, twice. */
RVDNAV_API rvdnav_status rvdnav_noise_median(const rvdnav_image* image, uint32_t* median_q1);
RVDNAV_API rvdnav_status rvdnav_find_fields(const rvdnav_image* image, rvdnav_fields* fields);

/* ---- the stages, each by itself ---- */
/* Smoothing by the 3x3 binomial; output rows of width bytes. */
RVDNAV_API rvdnav_status rvdnav_smooth(rvdnav_context* context, int32_t camera, const rvdnav_image* image,
                                       uint8_t* smoothed);
/* Words in a row of packed edge bits: bit x%32 of word x/32. */
RVDNAV_API uint32_t rvdnav_edge_row_words(int32_t width);
RVDNAV_API rvdnav_status rvdnav_detect_edges(rvdnav_context* context, int32_t camera, const uint8_t* smoothed,
                                             uint32_t* edge_bits, uint8_t* direction);
RVDNAV_API rvdnav_status rvdnav_filter_edges(rvdnav_context* context, int32_t camera, uint32_t* edge_bits);
RVDNAV_API rvdnav_status rvdnav_thin(rvdnav_context* context, int32_t camera, uint32_t* edge_bits);
RVDNAV_API rvdnav_status rvdnav_rectify_edges(rvdnav_context* context, int32_t camera, const uint32_t* edge_bits,
                                              const uint8_t* direction, rvdnav_edgel* edgels, uint32_t capacity,
                                              uint32_t* count);
/* accumulator: 180 rows (theta = -45 .. 134 degrees) of hough_rho_bins cells (those of rvdnav_context_config); rho = 0 in
 * the middle cell. */
RVDNAV_API rvdnav_status rvdnav_hough_vote(rvdnav_context* context, const rvdnav_edgel* edgels, uint32_t edgel_count,
                                           uint16_t* accumulator);
RVDNAV_API rvdnav_status rvdnav_hough_peaks(rvdnav_context* context, const uint16_t* accumulator, rvdnav_peak* peaks,
                                            uint32_t capacity, uint32_t* count);
/* The highest peak inside each window; votes = 0 where there is none. */
RVDNAV_API rvdnav_status rvdnav_hough_track(rvdnav_context* context, int32_t camera, const rvdnav_edgel* edgels,
                                            uint32_t edgel_count, const rvdnav_window* windows, uint32_t window_count,
                                            rvdnav_peak* peaks);
RVDNAV_API rvdnav_status rvdnav_extract_segments(rvdnav_context* context, int32_t camera, const rvdnav_edgel* edgels,
                                                 uint32_t edgel_count, const rvdnav_peak* peaks, uint32_t peak_count,
                                                 rvdnav_segment* segments, uint32_t capacity, uint32_t* count);
/* Needs a target: the width of its bars within the range gate is what pairs segments. */
RVDNAV_API rvdnav_status rvdnav_find_bars(rvdnav_context* context, int32_t camera, const rvdnav_segment* segments,
                                          uint32_t segment_count, rvdnav_bar* bars, uint32_t capacity, uint32_t* count);
/* Steps within half_width pixels to both sides, in profiles every step pixels along the edges; profiles without a usable
 * step are left out.  blur_sigma: of the steps, as measured in the image; 0: that of the configuration. */
RVDNAV_API rvdnav_status rvdnav_measure_edges(rvdnav_context* context, int32_t camera, const rvdnav_image* image,
                                              const rvdnav_model_edge* edges, uint32_t edge_count, double half_width,
                                              double step, double blur_sigma, rvdnav_edge_sample* samples,
                                              uint32_t capacity, uint32_t* count);
/* The same for the target's edges where a pose puts them: 80 profiles at most across each of up to 65536 edges, and none
 * within 3 pixels of its ends.  shortest: edges below that length, pixels, are left out.  An image that no edge is seen in
 * may be null.  capacity: at least 80 for each edge.  coverage: of each edge. */
RVDNAV_API rvdnav_status rvdnav_sample_edges(rvdnav_context* context, const rvdnav_image* left,
                                             const rvdnav_image* right, const rvdnav_seen_edge* edges,
                                             uint32_t edge_count, double half_width, double shortest,
                                             rvdnav_edge_sample* samples, uint32_t capacity, uint32_t* count,
                                             rvdnav_edge_coverage* coverage);
/* Matches left points (x, y and bar of each element) along the rows of the right image, and triangulates what it accepts. */
RVDNAV_API rvdnav_status rvdnav_correlate(rvdnav_context* context, const rvdnav_image* left, const rvdnav_image* right,
                                          rvdnav_match* matches, uint32_t match_count);
/* Least squares of the paper's equations (1)-(3); left, right: count pairs of rectified x, y; p_W: count triples, NaN where
 * the rays are parallel. */
RVDNAV_API rvdnav_status rvdnav_triangulate(rvdnav_context* context, const double* left, const double* right,
                                            uint32_t count, double* p_W);

/* Derivatives (line_count x 2 x effect->parameters) of the distances, pixels, of the projections of the lines' two ends
 * from the lines. */
RVDNAV_API rvdnav_status rvdnav_calibration_derivatives(const rvdnav_rig* rig, const rvdnav_calibration_effect* effect,
                                                        const rvdnav_measured_line* lines, uint32_t line_count,
                                                        double* derivatives);

/* ---- the pose, each step by itself; without a context ---- */
/* memory of these calls: aligned to 64 bytes, at least the size asked for, used during the call alone. */
RVDNAV_API rvdnav_status rvdnav_fit_edge_lines_size(uint32_t point_count, size_t* size);
/* A robust line through each edge's places, which come in their order along it; the lines by camera and edge; edges with too few places that agree have none.
 * weights (point_count): of the places, 0 for outliers and for edges without a line. */
RVDNAV_API rvdnav_status rvdnav_fit_edge_lines(const rvdnav_edge_point* points, uint32_t point_count, void* memory,
                                               size_t size, rvdnav_edge_line* lines, uint32_t capacity, uint32_t* count,
                                               double* weights);
RVDNAV_API rvdnav_status rvdnav_refine_pose_size(uint32_t line_count, uint32_t parameter_count, size_t* size);
/* The pose that fits the lines best, from the start on; a line is trusted or rejected as a whole. */
RVDNAV_API rvdnav_status rvdnav_refine_pose(const rvdnav_pose_problem* problem, void* memory, size_t size,
                                            rvdnav_refined_pose* result);

/* ---- the measurement: edges sampled, lines fitted, pose refined, until it stays ---- */
/* Bytes of work memory, and how many parameters there are. */
RVDNAV_API rvdnav_status rvdnav_measure_size(const rvdnav_context* context, const rvdnav_measurement_problem* problem,
                                             size_t* size, uint32_t* parameter_count);
/* The pose that the grey values give around the start.  An image may be null, not both.  memory: aligned to 64 bytes, at
 * least the size asked for, used during the call alone.  RVDNAV_ERROR_UNDETERMINED, _BEHIND or _NO_AGREEMENT where the
 * measured geometry gives no pose. */
RVDNAV_API rvdnav_status rvdnav_measure(const rvdnav_context* context, const rvdnav_image* left,
                                        const rvdnav_image* right, const rvdnav_measurement_problem* problem,
                                        void* memory, size_t size, rvdnav_measurement* measurement);

/* ---- the visible surface, off the frame's path ---- */
/* Bytes of work memory that rvdnav_surface needs. */
RVDNAV_API rvdnav_status rvdnav_surface_size(const rvdnav_context* context, size_t* size);
/* Points of the surface that both views see: zero crossings matched along epipolar rows, coarse to fine.  memory: aligned
 * to 64 bytes, at least the size asked for, used during the call alone.  The context's match_..., range_... and edge_floor
 * settings hold.  crossings: of the left view, those that became points and those that did not.  Needs two cameras. */
RVDNAV_API rvdnav_status rvdnav_surface(const rvdnav_context* context, const rvdnav_image* left,
                                        const rvdnav_image* right, void* memory, size_t size,
                                        rvdnav_surface_point* points, uint32_t capacity, uint32_t* count,
                                        uint32_t* crossings);

/* ---- host only: needs an operating system, absent from embedded builds ---- */
typedef struct rvdnav_runner rvdnav_runner;
/* Two threads that process the two views at once.  Allocates; one runner serves one context at a time. */
RVDNAV_API rvdnav_status rvdnav_runner_create(rvdnav_runner** runner);
RVDNAV_API void rvdnav_runner_destroy(rvdnav_runner* runner);
/* rvdnav_view on both images (either may be null), then rvdnav_join.  left_windows and right_windows belong together:
 * both empty means acquisition. */
RVDNAV_API rvdnav_status rvdnav_runner_process(rvdnav_runner* runner, rvdnav_context* context, const rvdnav_image* left,
                                               const rvdnav_image* right, const rvdnav_window* left_windows,
                                               uint32_t left_window_count, const rvdnav_window* right_windows,
                                               uint32_t right_window_count, rvdnav_frame_result* result);
/* Instruction set asked for by the environment variable RVDNAV_FORCE_ISA (scalar, avx2, neon); RVDNAV_ISA_AUTO if unset,
 * RVDNAV_ERROR_ISA if the name is unknown. */
RVDNAV_API rvdnav_status rvdnav_host_isa(int32_t* isa);
/* Steady clock, fits rvdnav_config.clock. */
RVDNAV_API uint64_t rvdnav_host_clock(void* user);

#ifndef RVDNAV_CDEF
#ifdef __cplusplus
}
#endif
#endif

#endif /* RVDNAV_RVDNAV_H */
