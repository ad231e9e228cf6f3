// Errors: every call that can fail returns an RfResult and, on failure, leaves
// one line in an RfError that says what, where (file, line, object) and what
// to do. Nothing in the library prints or exits.
#ifndef REFRAME_ERROR_H
#define REFRAME_ERROR_H

typedef enum RfResult
{
    RF_OK = 0,
    RF_ERROR_USAGE,       // the caller asked for something that cannot be (exit status 2)
    RF_ERROR_IO,          // a file could not be read or written
    RF_ERROR_FORMAT,      // a file is not what it claims to be
    RF_ERROR_UNSUPPORTED, // a file asks for something we do not have
    RF_ERROR_MEMORY,      // an allocation or the memory budget failed
    RF_ERROR_SCENE,       // a scene that cannot be rendered
    RF_ERROR_DEVICE,      // the ray tracing device reported a failure
    RF_ERROR_INTERRUPTED, // the caller asked to stop (exit status 130)
} RfResult;

typedef struct RfError
{
    RfResult code;
    char text[1024]; // one line, no newline at the end, truncated where too long
} RfError;

// Writes the line into `error` (which may be NULL) and returns `code`, so that
// `return rf_fail( error, RF_ERROR_IO, "…" );` is the whole of a failure.
// Control characters in the text are replaced by '?', so it stays one line.
RfResult rf_fail( RfError* error, RfResult code, const char* format, ... ) __attribute__( ( format( printf, 3, 4 ) ) );

// The stable name of a code, such as "RF_ERROR_IO".
const char* rf_result_name( RfResult code );

// Where warnings go: things the user should know that are no failure.
// `fn` NULL drops them. `count` counts them.
typedef struct RfLog
{
    void ( *fn )( void* user, const char* line );
    void* user;
    int count;
} RfLog;

// Sends one warning line. `log` may be NULL.
void rf_warn( RfLog* log, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );

#endif
