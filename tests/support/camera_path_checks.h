// Camera paths from texts, for tests.
#ifndef REFRAME_TESTS_CAMERA_PATH_CHECKS_H
#define REFRAME_TESTS_CAMERA_PATH_CHECKS_H

#include "scene/camera.h"
#include "scene/camera_path/camera_track.h"

// Writes the text to path.json in the folder of cli_run.h and loads it; fails
// the test where it does not load. Free with rf_destroy_camera.
RfCamera load_path( const char* text );

// Loads the text, which must fail in one line that names the file and has `part`.
void expect_path_fault( const char* text, const char* part );

// The view at a time of the path; fails the test where there is none.
RfView view_at( const RfCamera* camera, double time );

void assert_close( double got, double want, double tolerance );
void assert_three( const double got[3], double x, double y, double z, double tolerance );

#endif
