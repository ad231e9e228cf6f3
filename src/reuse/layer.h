// Layers: what the light of a batch consists of. A layer is a set of light paths, decided by the path alone: by the part of the light
// that it begins at (light/light.h) and, where pictures are sorted into passes, by its kind. Together they are all light; random
// numbers, densities and roulette do not look at them. A film is a sum of layers, each with the scale of its part in the film's
// frame (reuse/accumulate/hit_light.h).
//
// Removed light, which the clamp takes from the picture, or caustics that are left out, is a layer of each part as well, with a film of
// its own.
#ifndef REFRAME_REUSE_LAYER_H
#define REFRAME_REUSE_LAYER_H

#include <stdbool.h>

// Kinds, by what happens at the first surface that a camera ray meets: X( NAME, directions that bring it to glossy hits ). They are
// RF_PASS_AOVS in their order. Emission, direct light (from lights without a further surface), all other light that arrives; and
// of misses and glints what a chain reflects or transmits: hits at the end of a chain have its event (RfHitBatch.event).
// clang-format off
#define RF_LAYER_KINDS( X ) \
    X( EMISSION, NONE ) \
    X( DIRECT, SAMPLING ) \
    X( INDIRECT, SCATTERING ) \
    X( REFLECTION, NONE ) \
    X( TRANSMISSION, NONE )
// clang-format on
typedef enum RfLayerKind
{
#define RF_LAYER_KIND( NAME, directions ) RF_KIND_##NAME,
    RF_LAYER_KINDS( RF_LAYER_KIND )
#undef RF_LAYER_KIND
        RF_KINDS,
    RF_HIT_KINDS = RF_KIND_REFLECTION,
} RfLayerKind;

// The directions that bring light of a kind: light samples and the scattered one, which competes with them; all but light samples; or
// both.
typedef enum RfDirections
{
    RF_DIRECTIONS_NONE,
    RF_DIRECTIONS_SAMPLING,
    RF_DIRECTIONS_SCATTERING,
    RF_DIRECTIONS_ALL,
} RfDirections;

// Which layers batches have.
typedef struct RfLayerSet
{
    int parts;      // of the light, at least 1
    int base_parts; // of them, at least 1: misses, glints and light that holds in its own frame alone have these
    bool by_kind;   // else all kinds are one
    bool removed;   // with layers of removed light
} RfLayerSet;

static inline int rf_kinds( const RfLayerSet* set ) { return set->by_kind ? RF_KINDS : 1; }

static inline int rf_hit_kinds( const RfLayerSet* set ) { return set->by_kind ? RF_HIT_KINDS : 1; }

static inline int rf_layer_count( const RfLayerSet* set ) { return set->parts * ( rf_kinds( set ) + set->removed ); }

static inline int rf_layer( const RfLayerSet* set, int part, RfLayerKind kind )
{
    return set->by_kind ? part * RF_KINDS + (int)kind : part;
}

static inline int rf_removed_layer( const RfLayerSet* set, int part ) { return set->parts * rf_kinds( set ) + part; }

// The directions of a layer. `clamped`: with a clamp, which removes light of all directions but light samples.
static inline RfDirections rf_layer_directions( const RfLayerSet* set, int layer, bool clamped )
{
#define RF_OF_KIND( NAME, directions ) [RF_KIND_##NAME] = RF_DIRECTIONS_##directions,
    static const RfDirections s_of_kind[RF_KINDS] = { RF_LAYER_KINDS( RF_OF_KIND ) };
#undef RF_OF_KIND
    if ( layer >= rf_removed_layer( set, 0 ) )
        return clamped ? RF_DIRECTIONS_SCATTERING : RF_DIRECTIONS_NONE;
    return set->by_kind ? s_of_kind[layer % RF_KINDS] : RF_DIRECTIONS_ALL;
}

// Which layers a film is made of; RF_ALL: of all base parts, of all kinds.
#define RF_ALL ( -1 )
typedef struct RfFilmLayers
{
    int base, kind;
    bool removed; // light, else that of the picture
} RfFilmLayers;

// Whether a film has a layer.
static inline bool rf_is_in_film( RfFilmLayers film, int base, RfLayerKind kind )
{
    return ( film.base == RF_ALL || film.base == base ) && ( film.kind == RF_ALL || film.kind == (int)kind );
}

#endif
