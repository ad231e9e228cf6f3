// Internal to this folder: Embree 3 or 4, whichever the build found; their calls differ here alone.
#ifndef REFRAME_TRACE_EMBREE_H
#define REFRAME_TRACE_EMBREE_H

#include <stdbool.h>

#if REFRAME_EMBREE == 3
#include <embree3/rtcore.h>

// What Embree hands from a packet's query to the filter function.
typedef struct RTCIntersectContext RfRayContext;

static inline void rf_init_ray_context( RfRayContext* context, bool coherent )
{
    rtcInitIntersectContext( context );
    context->flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
}

static inline void rf_intersect_packet( const int* valid, RTCScene scene, RfRayContext* context, struct RTCRayHit16* packet )
{
    rtcIntersect16( valid, scene, context, packet );
}

static inline void rf_occlude_packet( const int* valid, RTCScene scene, RfRayContext* context, struct RTCRay16* ray )
{
    rtcOccluded16( valid, scene, context, ray );
}

#else
#include <embree4/rtcore.h>

typedef struct RfRayContext
{
    struct RTCRayQueryContext query; // first member: the filter function gets its address
    enum RTCRayQueryFlags flags;
} RfRayContext;

static inline void rf_init_ray_context( RfRayContext* context, bool coherent )
{
    rtcInitRayQueryContext( &context->query );
    context->flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
}

static inline void rf_intersect_packet( const int* valid, RTCScene scene, RfRayContext* context, struct RTCRayHit16* packet )
{
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments( &arguments );
    arguments.flags = context->flags;
    arguments.context = &context->query;
    rtcIntersect16( valid, scene, packet, &arguments );
}

static inline void rf_occlude_packet( const int* valid, RTCScene scene, RfRayContext* context, struct RTCRay16* ray )
{
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments( &arguments );
    arguments.flags = context->flags;
    arguments.context = &context->query;
    rtcOccluded16( valid, scene, ray, &arguments );
}

#endif
#endif
