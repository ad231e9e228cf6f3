// Errors and warnings. A call that can fail returns an RfResult and, on failure,
// leaves one line in an RfError that says what is wrong and where (file, line, object).
//
//     RfError error;
//     if ( rf_open_scene( path, &scene, NULL, &error ) != RF_OK )
//         fprintf( stderr, "%s: %s\n", rf_result_name( error.code ), error.text );
#ifndef REFRAME_ERROR_H
#define REFRAME_ERROR_H

#include "reframe/types.h"

RF_API_BEGIN

typedef enum RfResult
{
    RF_OK = 0,
    RF_ERROR_USAGE,       // the caller asked for something that cannot be
    RF_ERROR_IO,          // a file could not be read or written
    RF_ERROR_FORMAT,      // a file is not what it claims to be
    RF_ERROR_UNSUPPORTED, // a file asks for something we do not have
    RF_ERROR_MEMORY,      // an allocation failed, or the memory budget is too small
    RF_ERROR_SCENE,       // a scene that cannot be rendered
    RF_ERROR_DEVICE,      // the ray tracing device reported a failure
    RF_ERROR_INTERRUPTED, // the caller asked to stop
} RfResult;

// What the caller could change to get past an error, for programs that advise their
// users what to type.
typedef enum RfRemedy
{
    RF_REMEDY_NONE,            // the text says it all
    RF_REMEDY_MEMORY,          // a larger RfRenderSettings.memory, smaller frames or a smaller group
    RF_REMEDY_THREADS,         // fewer threads, or higher limits
    RF_REMEDY_LIMIT,           // smaller frames, a smaller group or a smaller RfRenderSettings.memory, or a higher limit
    RF_REMEDY_ESTIMATOR,       // another estimator, or none of what this one lacks
    RF_REMEDY_LAYER,           // the name of one of the layers of a file that has several
    RF_REMEDY_MOTION,          // likewise of the motion channels
    RF_REMEDY_DEPTH,           // likewise of the depth channel
    RF_REMEDY_FRAMES,          // a choice of frames that both of two sequences have
    RF_REMEDY_OVERWRITE,       // permission to replace a file that is there
    RF_REMEDY_CONVERT_MEMORY,  // a larger RfConvertOptions.memory
    RF_REMEDY_DENOISER,        // the library of rf_open_denoiser
    RF_REMEDY_CONVERT_SECONDS, // a larger RfConvertOptions.seconds
    RF_REMEDY_ACCEPT_LOSSES,   // RfSceneOptions.accept_losses, RfConvertOptions.accept_losses
} RfRemedy;

typedef struct RfError
{
    RfResult code;
    char text[1024]; // one line, no newline at the end, truncated where too long
    RfRemedy remedy;
    size_t least_memory; // with RF_REMEDY_MEMORY: the smallest budget that works, bytes; 0: not known
} RfError;

// Writes the line into `error` (which may be NULL), without a remedy, and returns `code`, so
// that `return rf_fail( error, RF_ERROR_IO, "..." );` is the whole of a failure, of a callback
// too. Control characters in the text are written as \n or \x1b, so it stays one line.
RfResult rf_fail( RfError* error, RfResult code, const char* format, ... ) __attribute__( ( format( printf, 3, 4 ) ) );

// The stable name of a code, such as "RF_ERROR_IO".
const char* rf_result_name( RfResult code );

// Where warnings go: things the user should know that are no failure. `fn` gets
// one line without a newline, `user` is passed on to it; NULL drops the lines. `count` counts them.
typedef struct RfLog
{
    void ( *fn )( void* user, const char* line );
    void* user;
    int count;
} RfLog;

// Sends one warning line. `log` may be NULL.
void rf_warn( RfLog* log, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );

RF_API_END

#endif
