// How far connections reach, and the footprints that go with it (src/reuse/estimators.md, section 16).
#include "light_paths/light_paths.h"

#define MOST_REACH 0.3f       // of directions: a chord
#define MOST_SHIFT 0.1f       // of the rays of infinite lights, in radii of the scene
#define RARE_FOOTPRINT 4.0f   // times as large as others, at most
#define FOOTPRINT_MARGIN 1.3f // over what the derivatives tell
#define LEAST_COSINE 0.2f     // at which light lands, for footprints

// How the chain's end moves over the surface at p: the eigenvectors of what steers it, longer first.
static bool find_moves( const RfChain* chain, RfVec3 p, RfVec3 normal, RfVec3 moves[2], float axis[2], float stretch[2] )
{
    RfVec3 meet, m[2], d = chain->end.d;
    if ( !rf_meet_plane( &chain->end, p, d, &meet, m ) )
        return false;
    float cosine = rf_dot( normal, d ), away = copysignf( rf_maxf( fabsf( cosine ), LEAST_COSINE ), cosine );
    for ( int k = 0; k < 2; ++k )
        m[k] = rf_madd( m[k], d, -rf_dot( m[k], normal ) / away );
    float a = rf_dot( m[0], m[0] ), b = rf_dot( m[0], m[1] ), c = rf_dot( m[1], m[1] ), half = 0.5f * ( a - c );
    float root = sqrtf( half * half + b * b ), phi = 0.5f * atan2f( b, half );
    axis[0] = cosf( phi );
    axis[1] = sinf( phi );
    moves[0] = rf_add( rf_scale( m[0], axis[0] ), rf_scale( m[1], axis[1] ) );
    moves[1] = rf_sub( rf_scale( m[1], axis[0] ), rf_scale( m[0], axis[1] ) );
    stretch[0] = FOOTPRINT_MARGIN * sqrtf( 0.5f * ( a + c ) + root );
    stretch[1] = FOOTPRINT_MARGIN * rf_length( moves[1] );
    return stretch[0] > 0.0f;
}

// How far a footprint of at most this radius allows connections to reach in each axis.
static void find_most( float radius, float limit, const float stretch[2], float most[2] )
{
    most[0] = rf_minf( limit, radius / stretch[0] );
    most[1] = rf_minf( limit, radius / rf_maxf( stretch[1], 1e-6f * stretch[0] ) );
}

// As far in both axes as the area takes; what is cut off one is added to the other.
static void set_reach( float area, const float most[2], RfReach* reach )
{
    reach->along = rf_minf( sqrtf( area ), most[0] );
    reach->across = rf_minf( area / reach->along, most[1] );
}

RfFootprint rf_find_footprint( const RfLightPaths* paths, const RfLights* lights, const RfChain* chain, float pdf, RfVec3 p,
                               RfVec3 normal )
{
    RfVec3 moves[2];
    RfFootprint f = { .most = 0.0f };
    float stretch[2], limit = chain->start.infinite ? MOST_SHIFT * lights->radius : MOST_REACH;
    if ( !( pdf > 0.0f ) || !find_moves( chain, p, normal, moves, f.reach.axis, stretch ) )
        return f;
    float area = paths->connections / ( RF_PI * (float)paths->emitted * pdf ), most[2], least_most[2];
    find_most( paths->most_radius, limit, stretch, most );
    find_most( RARE_FOOTPRINT * paths->most_radius, limit, stretch, least_most );
    f.most = RF_PI * most[0] * most[1];
    f.rare_most = RF_PI * least_most[0] * least_most[1];
    set_reach( area, most, &f.reach );
    float rare = paths->rare_connections / paths->connections * area;
    if ( f.reach.along * f.reach.across < rare )
        set_reach( rare, least_most, &f.reach );
    RfVec3 a = rf_scale( moves[0], FOOTPRINT_MARGIN * f.reach.along ),
           b = rf_scale( moves[1], FOOTPRINT_MARGIN * f.reach.across );
    float thick = sqrtf( rf_length( a ) * rf_length( b ) );
    f.half = rf_vec3( sqrtf( a.x * a.x + b.x * b.x ) + thick, sqrtf( a.y * a.y + b.y * b.y ) + thick,
                      sqrtf( a.z * a.z + b.z * b.z ) + thick );
    f.radius = f.reach.along * stretch[0];
    return f;
}
