// Random lanes of every scattering model, as inputs of the references too. Included by the files that check models.
#ifndef REFRAME_TESTS_DIFFERENTIAL_MODELS_H
#define REFRAME_TESTS_DIFFERENTIAL_MODELS_H

#include "differential/differential.h"
#include "differential/reference.h"
#include "support/bsdf_lanes.h"

// A grey surface, and the eye that looks at it.
typedef struct Surface
{
    RfVec3 n, wo;
    float diffuse, specular, shape, f90, coat_f0, coat_f90, clearcoat, clearcoat_alpha;
    RfVec3 coat_n;
    float sheen, sheen_alpha;
    float anisotropy;
    RfVec3 tangent;
    float film, film_ior, film_thickness;
    float tint, ior;     // of glass, whose metallic fraction is f90
    float through, side; // of translucent surfaces
} Surface;

Surface random_surface( RfBsdfKind kind, uint32_t stream, long i );

static inline void put_grey( int array, int lane, float value )
{
    s_lanes[array][lane] = s_lanes[array + 1][lane] = s_lanes[array + 2][lane] = value;
}

static inline void put_lane( int lane, const Surface* s )
{
    put( N, lane, s->n );
    put( WO, lane, s->wo );
    put_grey( DIFFUSE, lane, s->diffuse );
    put_grey( SPECULAR, lane, s->specular );
    put_grey( TINT, lane, s->tint + s->through ); // one place
    s_lanes[SHAPE][lane] = s->shape;
    s_lanes[F90][lane] = s->f90;
    s_lanes[COAT_F0][lane] = s->coat_f0;
    s_lanes[COAT_F90][lane] = s->coat_f90;
    s_lanes[CLEARCOAT][lane] = s->clearcoat;
    s_lanes[CLEARCOAT_ALPHA][lane] = s->clearcoat_alpha;
    put( COAT_N, lane, s->coat_n );
    put_grey( SHEEN, lane, s->sheen );
    s_lanes[SHEEN_ALPHA][lane] = s->sheen_alpha;
    s_lanes[ANISOTROPY][lane] = s->anisotropy;
    put( TANGENT, lane, s->tangent );
    s_lanes[FILM][lane] = s->film;
    s_lanes[FILM_IOR][lane] = s->film_ior;
    s_lanes[FILM_THICKNESS][lane] = s->film_thickness;
    s_lanes[CHOICE][lane] = s->side;
    s_lanes[IOR][lane] = s->ior;
}

// The inputs of the references: n, wo, wi and parameters.
void add_surface( Inputs* in, RfBsdfKind kind, const Surface* s, RfVec3 wi );

#endif
