// The runner: a case by every estimator, and what must hold of the pictures.
#include "hard/hard.h"
#include "hard/hard_double.h"
#include "hard/hard_pictures.h"
#include "path/mis.h"
#include "support/reference_tracer.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SIGNIFICANCE 1e-5      // of the mean of a picture and, by Šidák, of its blocks
#define MOST_WEIGHT 1.0000005f // a quotient of sums of 9 floats may round to a little more than 1

typedef struct Estimator
{
    const char* name;
    const char* estimator; // NULL: "reuse"
    bool frames;           // groups, else of one frame
    const char* tile;      // NULL: none
    RfWeights weights;
    bool lens;        // all eyes get a lens, and so does the reference
    bool unbiased;    // else only where all eyes are equal, so that all weights are
    bool connections; // light paths, in scenes where they have mirrors or glass to follow
    bool clamped;
} Estimator;

static const Estimator s_estimators[] = {
    { "path", NULL, false, NULL, RF_WEIGHTS_EXACT, false, true, false, false },
    { "tiles", NULL, false, "3x3", RF_WEIGHTS_EXACT, false, true, false, false },
    { "frames", NULL, true, NULL, RF_WEIGHTS_EXACT, false, true, false, false },
    { "both", NULL, true, "3x3", RF_WEIGHTS_EXACT, false, true, false, false },
    { "gradient", "gradient", false, "3x3", RF_WEIGHTS_EXACT, false, true, false, false },
    { "both, eq15", NULL, true, "3x3", RF_WEIGHTS_EQ15, false, false, false, false },
    { "both, unweighted", NULL, true, "3x3", RF_WEIGHTS_UNWEIGHTED, false, false, false, false },
    { "both, lens", NULL, true, "3x3", RF_WEIGHTS_EXACT, true, true, false, false },
    { "path, connections", NULL, false, NULL, RF_WEIGHTS_EXACT, false, true, true, false },
    { "both, connections", NULL, true, "3x3", RF_WEIGHTS_EXACT, false, true, true, false },
    { "both, clamp", NULL, true, "3x3", RF_WEIGHTS_EXACT, false, false, false, true },
};

typedef struct Result
{
    int nans, infinities, negatives, off; // values; `off`: not what is exactly known
    RfWeightRange weights;
    HardDifference is;
    double ratio; // relMSE over path tracing's; 0: not known
} Result;

static int samples_of( const HardScene* h, const HardForm* form )
{
    bool own = h->spp > 0 && ( form->statistics || h->spp < form->spp );
    return own ? h->spp : form->spp;
}

// The biased weightings have no bias where all eyes are equal (and no ray misses).
static bool is_unbiased( const Estimator* e, const HardScene* h )
{
    return e->unbiased || ( !e->clamped && hard_are_eyes_equal( h ) );
}

static RfRenderSettings settings_of( const HardScene* h, const Estimator* e, const HardForm* form )
{
    RfRenderSettings s = plain_settings();
    s.clamp = e->clamped ? RF_CLAMP_AUTO : 0.0;
    if ( e->estimator != NULL )
        s.estimator = rf_find_estimator( e->estimator );
    if ( e->tile != NULL )
        rf_parse_tile( e->tile, &s.tile );
    s.group = e->frames ? h->group : 0;
    s.weights = e->weights;
    s.normalize = e->weights == RF_WEIGHTS_EXACT && e->estimator == NULL ? RF_NORMALIZE_CROSSFIT : s.normalize;
    s.light_paths = e->connections ? RF_LIGHT_PATHS_ON : RF_LIGHT_PATHS_OFF;
    s.spp = samples_of( h, form );
    s.max_depth = h->max_depth;
    s.threads = 1; // small pictures; and the weights are watched
    s.memory = (size_t)256 << 20;
    return s;
}

// Light paths are drawn only where there is something for them to follow.
static bool is_for( const Estimator* e, const HardScene* h, const HardForm* form )
{
    RfEffect effects[RF_MAX_EFFECTS];
    RfRenderSettings settings = settings_of( h, e, form );
    rf_list_render_effects( &h->scene, h->eyes, h->eye_count, &settings, effects );
    if ( h->scene.movement != NULL && e->frames && ( e->connections || e->weights != RF_WEIGHTS_EXACT ) )
        return false; // refused
    return !e->connections || effects[RF_EFFECT_LIGHT_PATHS].on;
}

// `alone`: no other frame adds to it, so each sample counts 1 in its own pixel.
static void note_values( const Rendered* r, bool may_be_negative, bool alone, Result* out )
{
    for ( size_t i = 0; i < 3 * r->pixels * (size_t)r->count; ++i )
    {
        out->nans += isnan( r->rgb[i] );
        out->infinities += isinf( r->rgb[i] );
        out->negatives += !may_be_negative && r->rgb[i] < 0.0f;
    }
    for ( size_t i = 0; i < r->pixels * (size_t)r->count; ++i )
    {
        out->nans += isnan( r->weight[i] );
        out->infinities += isinf( r->weight[i] );
        out->negatives += r->weight[i] < 0.0f;
        out->off += alone && !( fabsf( r->weight[i] - 1.0f ) <= 1e-5f );
    }
}

static void keep_picture( const Rendered* r, int frame, HardPictures* p )
{
    const float* rgb = frame_rgb( r, frame );
    double sum = 0.0;
    p->rgb[p->count] = hard_new_picture( p );
    for ( size_t i = 0; i < 3 * r->pixels; ++i )
        p->rgb[p->count][i] = (double)rgb[i];
    for ( size_t i = 0; i < r->pixels; ++i )
        sum += (double)r->weight[(size_t)frame * r->pixels + i];
    p->weight[p->count] = sum / (double)r->pixels;
}

static HardPictures render( const RfTracer* tracer, const HardScene* h, const Estimator* e, const HardForm* form, Result* out )
{
    RfRenderSettings settings = settings_of( h, e, form );
    int seeds = is_unbiased( e, h ) ? form->seeds : 1, frame = h->eye_count / 2;
    RfEye eyes[HARD_MOST_EYES];
    memcpy( eyes, h->eyes, sizeof eyes );
    if ( e->lens )
        hard_add_lenses( h, eyes );
    HardPictures p = { .width = eyes->width, .height = eyes->height };
    out->weights = ( RfWeightRange ){ .least = FLT_MAX };
    rf_watch_weights( &out->weights );
    bool negative = ( settings.group != 0 && e->weights == RF_WEIGHTS_EXACT ) || e->estimator != NULL;
    for ( ; p.count < seeds; ++p.count )
    {
        settings.seed = (uint64_t)p.count + 1;
        bool all = p.count == 0 && form->statistics; // frames once, then the tested one
        AUTO_BY( free_rendered )
        Rendered r = all ? render_all( tracer, eyes, h->eye_count, &settings )
                         : render_frames( tracer, eyes, h->eye_count, &frame, 1, &settings );
        note_values( &r, negative, settings.group == 0 && e->estimator == NULL, out );
        keep_picture( &r, all ? frame : 0, &p );
    }
    rf_watch_weights( NULL );
    return p;
}

// With lenses only one estimator is compared: half the samples will do.
static HardPictures refer( const RfTracer* tracer, const HardCase* c, const HardScene* h, const HardForm* form, bool lens )
{
    RfEye eyes[HARD_MOST_EYES];
    memcpy( eyes, h->eyes, sizeof eyes );
    if ( lens )
        hard_add_lenses( h, eyes );
    const RfEye* eye = eyes + h->eye_count / 2;
    int spp = ( lens ? form->reference / 2 : form->reference ) * samples_of( h, form );
    HardPictures p = { .width = eye->width, .height = eye->height };
    AUTO_FREE float* plain = malloc( 3 * (size_t)eye->width * (size_t)eye->height * sizeof *plain );
    if ( plain == NULL )
        abort();
    for ( ; p.count < form->seeds; ++p.count )
    {
        double* rgb = p.rgb[p.count] = hard_new_picture( &p );
        uint64_t seed = 1000003u + (uint64_t)p.count; // far from those of the renders
        if ( c->reference == HARD_DOUBLE )
        {
            hard_double_image( &h->scene, eye, spp, h->max_depth, seed, rgb );
            continue;
        }
        ReferenceSettings s = {
            .spp = spp, .max_depth = h->max_depth, .light_samples = 1, .seed = seed, .frame = h->eye_count / 2
        };
        reference_image( tracer, eye, &s, plain );
        for ( int i = 0; i < 3 * eye->width * eye->height; ++i )
            rgb[i] = (double)plain[i];
    }
    return p;
}

// Tiles and gradients gain nothing from other frames, and gradients spread the noise of bright pixels over dark ones.
static double most_ratio( const HardCase* c, const Estimator* e )
{
    return e->frames ? c->factor : fmax( c->factor, e->estimator != NULL ? 6.0 : 1.5 );
}

static bool is_sound( const Result* r )
{
    return r->nans == 0 && r->infinities == 0 && r->negatives == 0 && r->off == 0 && r->weights.nans == 0 &&
           r->weights.least >= 0.0f && r->weights.most <= MOST_WEIGHT;
}

static bool verdict( const HardCase* c, const Estimator* e, const Result* r, bool compared )
{
    if ( !compared )
        return is_sound( r );
    return is_sound( r ) && r->is.whole_p > SIGNIFICANCE && r->is.block_p > SIGNIFICANCE && r->is.weight_p > SIGNIFICANCE &&
           ( c->factor == 0.0 || r->ratio <= most_ratio( c, e ) );
}

static void tell( const HardCase* c, const HardForm* form, const Estimator* e, const Result* r, bool compared, bool holds )
{
    printf( "%-26s %-17s NaN %d Inf %d negative %d off %d weight %.7g..%.7g", c->name, e->name, r->nans, r->infinities,
            r->negatives, r->off, (double)r->weights.least, (double)r->weights.most );
    if ( compared )
        printf( " bias %+.3f%% ± %.3f%% p %.2g %.2g %.2g relMSE %.3g", 100.0 * r->is.bias, 100.0 * r->is.interval, r->is.whole_p,
                r->is.block_p, r->is.weight_p, r->ratio );
    printf( "%s\n", holds ? "" : "  FAILS" );
    if ( form->table == NULL )
        return;
    fprintf( form->table, "| `%s` | %s | %s | %s | %.7g | %d, %d | ", c->name, c->hard, c->from, e->name, (double)r->weights.most,
             r->nans, r->infinities );
    if ( compared )
        fprintf( form->table, "%+.2f ± %.2f | %.2g | ", 100.0 * r->is.bias, 100.0 * r->is.interval, r->ratio );
    fprintf( form->table, "%s%s |\n", compared ? "" : "| | ", holds ? "yes" : "**no**" );
}

// What the pictures of a case are compared with, of sharp eyes and with lenses, and the noise of path tracing.
typedef struct Known
{
    HardPictures sharp, lens;
    double path_relmse;
} Known;

static bool is_referred( const HardCase* c ) { return c->reference == HARD_DOUBLE || c->reference == HARD_PLAIN; }

static void judge( const HardCase* c, const HardScene* h, const Estimator* e, const HardPictures* p, Known* known, Result* r )
{
    const HardPictures* reference = e->lens ? &known->lens : &known->sharp;
    r->is.whole_p = r->is.block_p = r->is.weight_p = 1.0;
    if ( is_referred( c ) )
        hard_compare( p, reference, &r->is );
    else if ( c->reference == HARD_VALUE )
        hard_compare_value( p, h, &r->is );
    if ( e->estimator == NULL && e->unbiased )
        r->is.weight_p = hard_mean_weight_p( p );
    double noise = hard_relmse( p, is_referred( c ) ? reference : p );
    known->path_relmse = e == s_estimators ? noise : known->path_relmse;
    // below: no noise to speak of; path tracing had no lens
    r->ratio = known->path_relmse > 1e-9 && !e->lens ? noise / known->path_relmse : 0.0;
}

static bool run_estimator( const RfTracer* tracer, const HardCase* c, const HardScene* h, const Estimator* e,
                           const HardForm* form, Known* known )
{
    Result r = { 0 };
    bool known_here = c->reference != HARD_FINITE && !( e->lens && h->sharp );
    bool compared = form->statistics && known_here && is_unbiased( e, h );
    HardPictures p = render( tracer, h, e, form, &r );
    r.off += c->reference == HARD_BLACK && known_here ? hard_count_lit( &p ) : 0;
    if ( compared )
        judge( c, h, e, &p, known, &r );
    bool holds = verdict( c, e, &r, compared );
    tell( c, form, e, &r, compared, holds );
    hard_free_pictures( &p );
    return holds;
}

static bool run_pictures( const HardCase* c, const HardForm* form )
{
    HardScene h = { .eye_count = 7, .group = 3, .max_depth = 4 };
    c->make( &h );
    AUTO_TRACER tracer = make_tracer( &h.scene );
    bool all = true;
    Known known = { 0 };
    if ( form->statistics && is_referred( c ) )
    {
        RfTracer* still = h.scene.movement != NULL ? make_tracer( &h.still ) : tracer;
        known.sharp = refer( still, c, &h, form, false );
        if ( !h.sharp )
            known.lens = refer( still, c, &h, form, true );
        if ( still != tracer )
            rf_destroy_tracer( still );
    }
    for ( size_t i = 0; i < sizeof s_estimators / sizeof *s_estimators; ++i )
        all = ( !is_for( s_estimators + i, &h, form ) || run_estimator( tracer, c, &h, s_estimators + i, form, &known ) ) && all;
    hard_free_pictures( &known.sharp );
    hard_free_pictures( &known.lens );
    rf_destroy_scene( &h.scene );
    rf_destroy_scene( &h.still );
    return all;
}

void hard_begin_table( const HardForm* form )
{
    if ( form->table != NULL )
        fprintf( form->table,
                 "| case | what is hard | what could go wrong | estimator, or what was found | largest weight | "
                 "NaN, Inf | bias %% | relMSE over path tracing's | holds |\n|---|---|---|---|---|---|---|---|---|\n" );
}

bool hard_run( const HardCase* c, const HardForm* form )
{
    bool holds;
    if ( c->reference == HARD_INPUT )
    {
        HardInput input = c->check();
        holds = input.holds;
        printf( "%-26s %s%s\n", c->name, input.text, holds ? "" : "  FAILS" );
        if ( form->table != NULL )
            fprintf( form->table, "| `%s` | %s | %s | %s | | | | | %s |\n", c->name, c->hard, c->from, input.text,
                     holds ? "yes" : "**no**" );
    }
    else
        holds = run_pictures( c, form );
    fflush( stdout );
    return holds;
}
