// What `tune` and `cost` share: options over those of a scene file, a search until a deadline, and a report of what it found, also
// after an interruption.
#ifndef REFRAME_CLI_TUNE_TRIAL_COMMAND_H
#define REFRAME_CLI_TUNE_TRIAL_COMMAND_H

#include "cli/options/render_options.h"
#include "measure/image_error.h"
#include "measure/trial_runs.h"
#include "reframe/render.h"
#include "scene_file/scene_file.h"

#include <jansson.h>

typedef struct RfTrialOptions
{
    RfRenderOptions render; // without output
    double budget;          // seconds; 0: nothing is rendered
    const char* svg;        // NULL: none
} RfTrialOptions;

typedef struct RfTrialCommand
{
    const RfCommandTable* table;
    RfTrialOptions* options;                      // which the table fills
    void ( *reset )( void );                      // sets them to their defaults
    RfResult ( *settle )( void* user, RfError* ); // checks what can be checked without the scene
    RfResult ( *search )( void* user, RfError* ); // sets `found` where there are results; interrupted, it says so
    RfResult ( *finish )( void* user, RfError* ); // what the report still needs
    void ( *print )( const void* user );
    json_t* ( *json )( const void* user );
    RfResult ( *plot )( const void* user, const char* path, RfError* );
    void* user;

    int argc;
    char** argv;
    double start; // rf_wall_seconds()
    bool help, found;
    // what is loaded, until the command ends
    RfSceneFile file; // options may point into it
    RfScene scene;
    RfCameraPath path; // its frames are the runs of the camera's: equal frames are rendered once
    RfTracer* tracer;
    int *frames, *asked, *asked_runs; // runs to be rendered; numbers of all frames asked for, equal ones too, and the run of each
    int asked_count;
    RfShot shot;         // what is rendered
    double beyond_depth; // share of the light (rf_find_light_beyond_depth)
} RfTrialCommand;

// Runs the command, frees what it has loaded, and returns the exit status.
int rf_run_trial_command( RfTrialCommand* command );

// What loading has left of the budget, at least half of it, and when that is well over, on rf_wall_seconds.
double rf_budget_left( const RfTrialCommand* command, double* deadline );

// Adds the keys that the rows of both commands have in their JSON; returns the object.
json_t* rf_trial_row_json( json_t* object, const RfTrialRow* row );

// "room.glb", of the scene.
const char* rf_scene_title( const RfTrialOptions* options );

#define RF_VERDICT_SIZE 1000

// What was found, in plain words. No figure is printed whose 95 % interval spans more than a factor of four.

// Is the value known well enough to be printed?
bool rf_is_known( const RfInterval* value );

// "1.8 times faster than path tracing at equal noise (95 %: 1.5 to 2.2)", "at least 5 times faster …", "not compared with …", or
// how many seconds it takes to know, of which `spent` were spent.
void rf_format_gain( const RfInterval* gain, double spent, char* text, size_t size );

// A cell of a table: "0.042", ">0.011" or "?".
#define RF_FIGURE_SIZE 24
void rf_format_figure( const RfInterval* value, char text[RF_FIGURE_SIZE] );

// "4.1 s", "16 min", "2.6 h", "3 days".
void rf_format_span( double seconds, char* text, size_t size );

// "groups of 7 and 3x3 tiles", "groups of 7", "3x3 tiles", "path tracing".
void rf_format_reuse( int eyes, const RfTile* tile, char* text, size_t size );

#endif
