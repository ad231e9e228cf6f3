// Internal to this folder: Embree 3 or 4, whichever the build found; what differs between them stands here alone.
#ifndef REFRAME_TRACE_EMBREE_H
#define REFRAME_TRACE_EMBREE_H

#include <stdbool.h>
#include <string.h>

#if REFRAME_EMBREE == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

// What a packet is traced with. Embree passes the address of the first member to the filter function.
typedef struct RfRayContext
{
#if REFRAME_EMBREE == 3
    struct RTCIntersectContext embree;
#else
    struct RTCRayQueryContext embree;
    enum RTCRayQueryFlags flags;
#endif
    bool halved; // packets of 16 are traced as two of 8
} RfRayContext;

// Whether packets of 16 are to be traced as two of 8: without AVX-512 Embree has none of 16. Version 3 then halves them itself,
// without regard to `valid`; version 4 traces their rays one by one.
static inline bool rf_halves_packets( RTCDevice device )
{
    return rtcGetDeviceProperty( device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED ) == 0 &&
           rtcGetDeviceProperty( device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED ) != 0;
}

// One half of a packet: 8 of each field's 16 numbers of four bytes.
static inline void rf_take_half( void* half, const void* packet, int which, size_t bytes )
{
    for ( size_t at = 0; at < bytes; at += 32 )
        memcpy( (char*)half + at, (const char*)packet + 2 * at + 32 * which, 32 );
}

static inline void rf_put_half( void* packet, const void* half, int which, size_t bytes )
{
    for ( size_t at = 0; at < bytes; at += 32 )
        memcpy( (char*)packet + 2 * at + 32 * which, (const char*)half + at, 32 );
}

_Static_assert( sizeof( struct RTCRayHit16 ) == 2 * sizeof( struct RTCRayHit8 ), "fields of 16 are twice those of 8" );

static inline void rf_init_ray_context( RfRayContext* context, bool coherent, bool halved )
{
    context->halved = halved;
#if REFRAME_EMBREE == 3
    rtcInitIntersectContext( &context->embree );
    context->embree.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
#else
    rtcInitRayQueryContext( &context->embree );
    context->flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
#endif
}

// Nearest hits of the rays whose `valid` is −1.
static inline void rf_intersect_packet( const int* valid, RTCScene scene, RfRayContext* context, struct RTCRayHit16* packet )
{
#if REFRAME_EMBREE == 3
    struct RTCIntersectContext* with = &context->embree;
#define INTERSECT( width, lanes, rays ) rtcIntersect##width( lanes, scene, with, rays )
#else
    struct RTCIntersectArguments with;
    rtcInitIntersectArguments( &with );
    with.flags = context->flags;
    with.context = &context->embree;
#define INTERSECT( width, lanes, rays ) rtcIntersect##width( lanes, scene, rays, &with )
#endif
    if ( !context->halved )
    {
        INTERSECT( 16, valid, packet );
        return;
    }
    for ( int i = 0; i < 2; ++i )
    {
        struct RTCRayHit8 half;
        rf_take_half( &half, packet, i, sizeof half );
        INTERSECT( 8, valid + 8 * i, &half );
        rf_put_half( packet, &half, i, sizeof half );
    }
#undef INTERSECT
}

// Sets `tfar` of the rays whose `valid` is −1 to −∞ where something is in their way.
static inline void rf_occlude_packet( const int* valid, RTCScene scene, RfRayContext* context, struct RTCRay16* ray )
{
#if REFRAME_EMBREE == 3
    struct RTCIntersectContext* with = &context->embree;
#define OCCLUDED( width, lanes, rays ) rtcOccluded##width( lanes, scene, with, rays )
#else
    struct RTCOccludedArguments with;
    rtcInitOccludedArguments( &with );
    with.flags = context->flags;
    with.context = &context->embree;
#define OCCLUDED( width, lanes, rays ) rtcOccluded##width( lanes, scene, rays, &with )
#endif
    if ( !context->halved )
    {
        OCCLUDED( 16, valid, ray );
        return;
    }
    for ( int i = 0; i < 2; ++i )
    {
        struct RTCRay8 half;
        rf_take_half( &half, ray, i, sizeof half );
        OCCLUDED( 8, valid + 8 * i, &half );
        memcpy( ray->tfar + 8 * i, half.tfar, sizeof half.tfar );
    }
#undef OCCLUDED
}

#endif
