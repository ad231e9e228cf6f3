// What `tune` and `cost` share: options over those of a scene file, a search until a deadline, and a report of what it found, also
// after an interruption.
#ifndef REFRAME_CLI_TUNE_TRIAL_COMMAND_H
#define REFRAME_CLI_TUNE_TRIAL_COMMAND_H

#include "cli/options/render_options.h"
#include "measure/trial_runs.h"
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

// The picture, and keys that the rows of both commands have in their JSON.
json_t* rf_trial_row_json( json_t* object, const RfTrialRow* row );

// "room.glb", of the scene.
const char* rf_scene_title( const RfTrialOptions* options );

#endif
