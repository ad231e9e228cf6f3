// The suite of hard cases: one table of cases, one runner. A case is a scene or an input made by code, what is hard about
// it, and what must hold.
#ifndef REFRAME_TESTS_HARD_H
#define REFRAME_TESTS_HARD_H

#include "support/owned.h"
#include "support/render_support.h"
#include "support/scene_builder.h"

#include <stdio.h>

#define HARD_MOST_EYES 9

// A scene, a camera path and how it is rendered.
typedef struct HardScene
{
    RfScene scene;
    RfScene still; // as it is in the tested frame, where something moves
    RfEye eyes[HARD_MOST_EYES];
    int eye_count; // 7 unless the case sets another; the middle one is tested
    int group;     // half-width for `frames` and `both`; 3 unless the case sets another
    int max_depth; // 4 unless the case sets another
    int spp;       // per seed; 0: that of the form of the run
    double value;  // of HARD_VALUE: radiance of every pixel and channel
    double within; // of HARD_VALUE: relative, besides the noise
    bool sharp;    // what is known holds without lenses alone
} HardScene;

// What the pictures are compared with.
typedef enum HardReference
{
    HARD_DOUBLE, // a path tracer in doubles that shares no code with the library (hard_double.h)
    HARD_PLAIN,  // the plain path tracer of tests/support, for what the other one lacks: mirrors, glass, skies with a map
    HARD_VALUE,  // a closed form: one radiance everywhere
    HARD_BLACK,  // exactly black
    HARD_FINITE, // nothing: which of two coincident surfaces is seen is not defined
    HARD_INPUT,  // no picture at all: `check` says what must hold
} HardReference;

// What an input case found; its text is printed.
typedef struct HardInput
{
    bool holds;
    char text[200];
} HardInput;

typedef struct HardCase
{
    const char* name;
    const char* hard; // what is hard about it
    const char* from; // where it came from: what could go wrong
    HardReference reference;
    double factor; // relMSE of an estimator over that of path tracing at equal samples, at most; 0: not compared
    void ( *make )( HardScene* h );
    HardInput ( *check )( void );
} HardCase;

// A table of cases that ends with a row without a name.
extern const HardCase g_hard_eyes[], g_hard_lenses[], g_hard_geometry[], g_hard_light[], g_hard_materials[], g_hard_projections[],
    g_hard_transport[], g_hard_numbers[], g_hard_poisson[], g_hard_moving[], g_hard_surfaces[];

// How long a run takes: the short form is that of the tests.
typedef struct HardForm
{
    int seeds;
    int spp;         // per seed and frame, a multiple of what groups of 7 need
    int reference;   // samples of the reference, times spp
    bool statistics; // else only what holds of every picture: no NaN, no Inf, the range of the weights
    FILE* table;     // Markdown, a row for each result; NULL: none
} HardForm;

// Begins form->table.
void hard_begin_table( const HardForm* form );

// Runs a case by all estimators and prints a line for each; false if anything does not hold.
bool hard_run( const HardCase* c, const HardForm* form );

// The stage of most cases: a floor, two walls, a block, a light above; no curved surfaces. `object` is the block and the
// floor. 7 eyes 0.1 m apart look at the block.
void hard_stage( HardScene* h, RfMaterial object );

// Floor and block that are easy to see through: grey, glossy, metallic.
RfMaterial hard_grey( void );
RfMaterial hard_glossy( void );

// 7 eyes from `from` in steps of `step`, all along `forward`, yfov in degrees.
void hard_eyes( HardScene* h, RfVec3 from, RfVec3 step, RfVec3 forward, double degrees );

// Sets the eyes' film.
void hard_film( HardScene* h, int width, int height );

// x to scale x + shift: the scene, its lamps and its eyes.
void hard_move( HardScene* h, float scale, RfVec3 shift );

// Gives each of a copy of the eyes a lens; the tested one's is round, as that of the references.
void hard_add_lenses( const HardScene* h, RfEye* eyes );

// True if all eyes see the same.
bool hard_are_eyes_equal( const HardScene* h );

// Opens a finished scene for more; then finish_scene.
SceneBuilder hard_reopen( RfScene* scene );

#define HARD_WIDTH 16
#define HARD_HEIGHT 12

#endif
