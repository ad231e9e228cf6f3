// Options of `reframe render`.
#ifndef REFRAME_CLI_OPTIONS_RENDER_OPTIONS_H
#define REFRAME_CLI_OPTIONS_RENDER_OPTIONS_H

#include "base/json.h"
#include "cli/options/options.h"
#include "reframe/camera.h"
#include "reframe/effects.h"
#include "reframe/render.h"
#include "reframe/scene.h"

// The words of --effects.
enum
{
    RF_EFFECTS_AUTO,
    RF_EFFECTS_ALL,
};
extern const char* const rf_effects_words[];

typedef struct RfRenderOptions
{
    const char* scene;
    const char* camera; // NULL: the scene's first animated one, else its first
    const char* frames; // NULL: all
    RfFps fps;
    RfSize size;
    const char* overscan; // NULL: none
    const char* shutter;  // NULL: the camera's
    int blur_steps;
    double fstop;
    bool fstop_given;
    const char* focus;         // NULL: the camera's
    RfSceneOptions movement;   // what moves besides the camera
    int effects;               // RF_EFFECTS_AUTO or RF_EFFECTS_ALL
    const char* no_effect;     // NULL: none
    uint64_t left_out;         // a set of RF_EFFECT_BITs: those of no_effect
    RfRenderSettings settings; // max_depth is 0 until rf_take_scene_depth
    bool depth_of_scene;
    bool spp_given;
    int filter, estimator;   // indices of their words; of the filter -1: not given
    const char* tile;        // NULL: that of the estimator
    const char* aov;         // NULL: none
    const char* cryptomatte; // likewise
    bool alpha, alpha_given;
    bool denoise;
    const char* denoiser; // its library; NULL: that which is found
    const char* output;
    const char* preview; // NULL: none
    double autosave;     // seconds; 0: never
    bool resume;
    bool overwrite;
    bool check;       // only look at the frames that are there
    int nodes;        // machines that the frames are cut for; 0: none
    const char* json; // NULL: none
    bool quiet;
    bool verbose;
} RfRenderOptions;

RfRenderOptions rf_default_render_options( void );

// Parses and checks what can be checked without the scene. With *help set the
// help was asked for and nothing else is valid.
RfResult rf_parse_render_options( int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error );

// The defaults, overridden by the `render` object of a scene file; errors name the
// JSON path. Strings point into the JSON.
struct RfField;
RfResult rf_read_render_defaults( const struct RfField* defaults, RfRenderOptions* options );
// The defaults, overridden by the command line, which has been parsed before.
RfResult rf_parse_render_options_over( const struct RfField* defaults, int argc, char** argv, RfRenderOptions* options,
                                       RfError* error );

// Is the text of --preview a port, "8080" or ":8080"? Else it is the name of a file.
bool rf_is_port( const char* text, int* port );

// The path that --camera, --fps, --size, --overscan and --shutter, --fstop, --focus ask for; *path points to *lens. Fails with
// RF_ERROR_USAGE.
RfResult rf_parse_path_options( const RfRenderOptions* options, RfLens* lens, RfPathOptions* path, RfError* error );

// Creates the path that they ask for, and warns where the picture has not the camera's aspect ratio.
RfResult rf_create_asked_path( const RfRenderOptions* options, const RfScene* scene, RfCameraPath* path, RfLog* log,
                               RfError* error );

// Takes the filter that was given, or that of the estimator.
void rf_settle_filter( RfRenderOptions* options );

// Sets settings.estimator from --estimator, and settings.tile to its default.
void rf_take_estimator_option( RfRenderOptions* options );

// Sets settings.tile from --tile, if it was given.
RfResult rf_parse_tile_option( RfRenderOptions* options, RfError* error );

// Looks whether the scene has the light groups that its file asks for; what the command line asks for is left to the render. Fails
// with RF_ERROR_SCENE, naming the key, and RF_ERROR_MEMORY.
struct RfSceneFile;
RfResult rf_check_file_light_groups( const RfRenderOptions* options, const struct RfSceneFile* file, const RfScene* scene,
                                     RfError* error );

// Completes the settings once all options are known: enums from their words, and the limit
// of samples for --noise, --flicker and --time where none was given, by one rule for all commands.
// Fails with RF_ERROR_USAGE for options that exclude each other.
RfResult rf_settle_render_options( RfRenderOptions* options, RfError* error );

// Their table.
extern const RfCommandTable rf_render_table;

// --effects and --no-effect, and the options that decide on effects.

// Leaves out and forces what the options ask for, before the scene has a path, and warns of pictures that are others then.
RfResult rf_take_effect_options( const RfRenderOptions* options, RfScene* scene, RfLog* log, RfError* error );

// The option that decides on an effect, such as "--aov albedo"; NULL where the scene or the camera does.
const char* rf_effect_option( RfEffectId effect );

// Takes the limit of paths that the scene asks for, or none, where no option gives one. Once the scene is loaded.
void rf_take_scene_depth( RfRenderOptions* options, const RfScene* scene );

// Warns where max_depth takes light, and says its share; 0 without a limit.
RfResult rf_warn_of_depth( const RfShot* shot, const RfRenderOptions* options, RfLog* log, double* share, RfError* error );

// The runs of the path that hold any of the frames, ascending, and their number: what is to be rendered. The
// caller frees them; NULL where memory ran out.
int* rf_runs_of_frames( const RfCameraPath* path, const int* frames, int frame_count, int* run_count );

// Rewrites the error of an option ("--frames: there is no frame 9") as one of the
// scene file ("scene.json: render.frames: there is no frame 9").
RfResult rf_fail_file_option( const RfField* field, const RfError* error );

#endif
