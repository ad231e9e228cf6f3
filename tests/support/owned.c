#include "support/owned.h"

#include "trace/trace.h"

#include <stdlib.h>

void destroy_tracer_at( void* tracer ) { rf_destroy_tracer( *(RfTracer**)tracer ); }

void free_at( void* pointer ) { free( *(void**)pointer ); }
