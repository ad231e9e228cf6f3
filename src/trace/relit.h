// Tracers that share all but the light with another. A tracer under some of its lights alone: since light is linear, pictures by it sum to the picture under all of them, and with the
// same random numbers they do so to rounding.
#ifndef REFRAME_TRACE_RELIT_H
#define REFRAME_TRACE_RELIT_H

#include "trace/trace.h"

typedef struct RfRelitTracer RfRelitTracer;

// Whether a light of the tracer stays lit.
typedef bool RfIsLit( void* user, uint32_t light );

// For a tracer that paths of one frame are traced with; it must outlive this one. All but the light is shared, lights are selected
// with the same probabilities, and nothing moves in its scene. Fails with RF_ERROR_MEMORY.
RfResult rf_create_relit_tracer( const RfTracer* tracer, RfIsLit* is_lit, void* user, RfRelitTracer** relit, RfError* error );
void rf_destroy_relit_tracer( RfRelitTracer* relit );

const RfTracer* rf_relit_tracer( const RfRelitTracer* relit );

// A tracer whose lights that hold are split by light groups (light/light.h). The other must outlive it. Fails with RF_ERROR_MEMORY.
RfResult rf_create_split_tracer( const RfTracer* tracer, const RfLightGroups* groups, RfTracer** split, RfError* error );
// NULL is allowed.
void rf_destroy_split_tracer( RfTracer* split );

#endif
