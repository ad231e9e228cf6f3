// Converts other formats to .glb: PLY here, the others by the importer, a process of its own with limits.
#include "convert/convert.h"

#include "base/file.h"
#include "base/remedy.h"
#include "base/system.h"
#include "base/try.h"
#include "base/words.h"
#include "image/atomic_file.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#define EXPORT_INSTEAD "export it as glTF (.glb) from the program it came from"

// The importer's standard error, line by line: "warning: …", "error: …" and finally "counts:
// …". Output beyond this size is discarded.
typedef struct Messages
{
    char text[32768];
    size_t size;
} Messages;

typedef enum End
{
    END_EXIT,
    END_TIMEOUT,
    END_INTERRUPT,
} End;

// Finds reframe-import beside the running program, or relative to it in
// ../libexec/reframe or ../lib/reframe.
static RfResult find_importer( char* path, size_t size, RfError* error )
{
    static const char* const folders[] = { "", "../libexec/reframe/", "../lib/reframe/" };
    char self[4096];
    ssize_t length = readlink( "/proc/self/exe", self, sizeof self - 1 );
    if ( length <= 0 )
        return rf_fail( error, RF_ERROR_IO, "reframe-import: cannot be found: /proc is missing: mount it" );
    self[length] = 0;
    char* slash = strrchr( self, '/' );
    if ( slash != NULL )
        slash[1] = 0;
    for ( size_t i = 0; i < sizeof folders / sizeof folders[0]; ++i )
    {
        char found[8192];
        int length_found = snprintf( found, sizeof found, "%s%sreframe-import", self, folders[i] );
        if ( (size_t)length_found >= size || access( found, X_OK ) != 0 )
            continue;
        memcpy( path, found, (size_t)length_found + 1 );
        return RF_OK;
    }
    return rf_fail( error, RF_ERROR_IO, "reframe-import: is neither in %s nor in ../libexec/reframe: install reframe with it",
                    self );
}

// Runs in the child. The result is written to standard output, which is the open file, so that
// the importer needs no file name. Only async-signal-safe calls.
static void become_importer( const RfImporterRun* run, int out, int messages, char* const* arguments )
{
    int nothing = open( "/dev/null", O_RDONLY );
    signal( SIGXFSZ, SIG_IGN );
    if ( nothing >= 0 && dup2( nothing, 0 ) >= 0 && dup2( out, 1 ) >= 0 && dup2( messages, 2 ) >= 0 )
        execv( run->program, arguments );
    _exit( 127 );
}

static RfResult start( const RfImporterRun* run, int out, pid_t* child, int* messages, RfError* error )
{
    char memory[32], seconds[32], scale[32];
    snprintf( memory, sizeof memory, "%zu", run->memory );
    snprintf( seconds, sizeof seconds, "%.0f", run->seconds < 1.0 ? 1.0 : run->seconds );
    // the bit pattern of the number avoids locales and rounding
    unsigned long long bits;
    memcpy( &bits, &run->scale, sizeof bits );
    snprintf( scale, sizeof scale, "%llx", bits );
    static const char* const ups[] = { "file", "y", "z" }; // as RfUpAxis
    char* arguments[] = { "reframe-import",
                          (char*)run->source,
                          memory,
                          seconds,
                          (char*)ups[run->up],
                          scale,
                          run->accept_losses ? "accept" : "refuse",
                          NULL };
    int ends[2];
    if ( pipe( ends ) != 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: the importer cannot be started: %s", run->source, strerror( errno ) );
    fcntl( ends[0], F_SETFD, FD_CLOEXEC );
    fcntl( ends[1], F_SETFD, FD_CLOEXEC );
    *child = fork();
    if ( *child == 0 )
        become_importer( run, out, ends[1], arguments );
    int failure = errno;
    close( ends[1] );
    *messages = ends[0];
    if ( *child > 0 )
        return RF_OK;
    close( ends[0] );
    return rf_fail( error, RF_ERROR_IO, "%s: the importer cannot be started: %s", run->source, strerror( failure ) );
}

static bool read_available( int fd, Messages* messages )
{
    char bytes[4096];
    ssize_t count = read( fd, bytes, sizeof bytes );
    if ( count < 0 )
        return errno == EINTR || errno == EAGAIN;
    size_t room = sizeof messages->text - 1 - messages->size, taken = (size_t)count < room ? (size_t)count : room;
    memcpy( messages->text + messages->size, bytes, taken );
    messages->size += taken;
    return count > 0;
}

// Waits for the child to exit, and kills it at a limit or an interrupt.
static End wait_for( const RfImporterRun* run, pid_t child, int fd, Messages* messages, int* status )
{
    double deadline = rf_wall_seconds() + run->seconds;
    End end = END_EXIT;
    bool open = true;
    for ( ;; )
    {
        struct pollfd poll_fd = { .fd = open ? fd : -1, .events = POLLIN };
        if ( poll( &poll_fd, 1, 20 ) > 0 )
            open = read_available( fd, messages );
        pid_t ended = waitpid( child, status, WNOHANG );
        if ( ended == child || ( ended < 0 && errno != EINTR ) )
            break;
        if ( end != END_EXIT )
            continue; // already killed
        if ( run->is_interrupted != NULL && run->is_interrupted( run->user ) )
            end = END_INTERRUPT;
        else if ( rf_wall_seconds() > deadline )
            end = END_TIMEOUT;
        if ( end != END_EXIT )
            kill( child, SIGKILL );
    }
    fcntl( fd, F_SETFL, O_NONBLOCK );
    struct pollfd rest = { .fd = fd, .events = POLLIN };
    while ( open && poll( &rest, 1, 0 ) > 0 )
        open = read_available( fd, messages );
    return end;
}

// Sends the warnings to the log; returns the error message, or NULL.
static const char* read_messages( Messages* messages, RfModelCounts* counts, RfLog* log )
{
    const char* failure = NULL;
    messages->text[messages->size] = 0;
    char* rest = messages->text;
    for ( char* line = strtok_r( rest, "\n", &rest ); line != NULL; line = strtok_r( NULL, "\n", &rest ) )
    {
        if ( strncmp( line, "warning: ", 9 ) == 0 )
            rf_warn( log, "%s", line + 9 );
        else if ( strncmp( line, "error: ", 7 ) == 0 )
            failure = line + 7;
        else if ( strncmp( line, "lost: ", 6 ) == 0 )
            failure = line + 6;
        else if ( strncmp( line, "counts: ", 8 ) == 0 )
            (void)sscanf( line + 8, "%llu %d %d %d %d %d %d %d %d %d", &counts->triangles, &counts->meshes, &counts->nodes,
                          &counts->materials, &counts->images, &counts->cameras, &counts->lights, &counts->skins, &counts->morphs,
                          &counts->animations );
    }
    return failure;
}

static RfResult report_end( const RfImporterRun* run, End end, int status, bool no_memory, const char* failure, RfError* error )
{
    const char* source = run->source;
    if ( end == END_INTERRUPT )
        return rf_fail( error, RF_ERROR_INTERRUPTED, "%s: interrupted", source );
    bool signalled = WIFSIGNALED( status );
    if ( end == END_TIMEOUT || ( signalled && WTERMSIG( status ) == SIGXCPU ) )
        return rf_advise( rf_fail( error, RF_ERROR_FORMAT, "%s: the importer had not finished after %g s", source, run->seconds ),
                          RF_REMEDY_CONVERT_SECONDS, 0, error );
    if ( no_memory )
        return rf_advise(
            rf_fail( error, RF_ERROR_MEMORY, "%s: the importer needs more than %zu MiB of memory", source, run->memory >> 20 ),
            RF_REMEDY_CONVERT_MEMORY, 0, error );
    if ( signalled )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: the importer crashed on it (%s): " EXPORT_INSTEAD, source,
                        strsignal( WTERMSIG( status ) ) );
    if ( WEXITSTATUS( status ) == 0 )
        return RF_OK;
    if ( WEXITSTATUS( status ) == 127 )
        return rf_fail( error, RF_ERROR_IO, "%s: cannot be started: reinstall reframe", run->program );
    return rf_fail( error, RF_ERROR_FORMAT, "%s: %s", source,
                    failure != NULL ? failure : "the importer failed on it: " EXPORT_INSTEAD );
}

RfResult rf_run_importer( const RfImporterRun* run, RfModelCounts* counts, RfLog* log, RfError* error )
{
    *counts = ( RfModelCounts ){ 0 };
    RfAtomicFile file;
    RF_TRY( rf_open_atomic_file( run->target, &file, error ) );
    pid_t child = -1;
    int fd = -1, status = 0;
    RfResult result = start( run, file.fd, &child, &fd, error );
    if ( result == RF_OK )
    {
        Messages messages = { .size = 0 };
        End end = wait_for( run, child, fd, &messages, &status );
        close( fd );
        messages.text[messages.size] = 0;
        bool no_memory = strstr( messages.text, "bad_alloc" ) != NULL || strstr( messages.text, "out of memory" ) != NULL;
        bool lost = strncmp( messages.text, "lost: ", 6 ) == 0 || strstr( messages.text, "\nlost: " ) != NULL;
        const char* failure = read_messages( &messages, counts, log );
        result = report_end( run, end, status, no_memory, failure, error );
        if ( result != RF_OK && lost )
            rf_advise( result, RF_REMEDY_ACCEPT_LOSSES, 0, error );
    }
    return rf_end_atomic_file( &file, result, error );
}

RfConvertOptions rf_default_convert_options( void )
{
    return ( RfConvertOptions ){ .scale = 1.0, .memory = (size_t)4 << 30, .seconds = 120.0 };
}

#define HEAD_BYTES 32

// The first bytes; what cannot be read is an error of the system's words.
static RfResult read_head( const char* path, char head[HEAD_BYTES], RfError* error )
{
    struct stat status;
    memset( head, 0, HEAD_BYTES );
    if ( stat( path, &status ) == 0 && !S_ISREG( status.st_mode ) )
        return rf_fail( error, RF_ERROR_IO, "%s: not a regular file", path );
    FILE* file = fopen( path, "rb" );
    if ( file == NULL )
        return rf_fail_io( path, "cannot be read", errno, error );
    size_t count = fread( head, 1, HEAD_BYTES, file );
    fclose( file );
    return count > 0 ? RF_OK : rf_fail( error, RF_ERROR_FORMAT, "%s: is empty: write it anew", path );
}

static RfResult check_files( const char* from, const char* to, bool overwrite, char head[HEAD_BYTES], RfError* error )
{
    if ( !rf_has_extension( to, ".glb" ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: only .glb is written: name it .glb", to );
    RF_TRY( read_head( from, head, error ) );
    RF_TRY( rf_refuse_foreign_file( from, head, HEAD_BYTES, true, error ) );
    if ( rf_has_extension( from, ".glb" ) || rf_has_extension( from, ".gltf" ) || memcmp( head, "glTF", 4 ) == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: is glTF already and needs no conversion: render it as it is", from );
    struct stat status;
    if ( !overwrite && lstat( to, &status ) == 0 )
        return rf_advise( rf_fail( error, RF_ERROR_IO, "%s: already exists", to ), RF_REMEDY_OVERWRITE, 0, error );
    return rf_try_output_file( to, error );
}

static RfResult convert_by_assimp( const char* from, const char* to, const RfConvertOptions* options, RfModelCounts* counts,
                                   RfLog* log, RfError* error )
{
    char program[8192];
    RfResult result = options->importer == NULL ? find_importer( program, sizeof program, error ) : RF_OK;
    RfImporterRun run = { .program = options->importer != NULL ? options->importer : program,
                          .source = from,
                          .target = to,
                          .memory = options->memory,
                          .seconds = options->seconds,
                          .up = options->up,
                          .scale = options->scale,
                          .accept_losses = options->accept_losses,
                          .is_interrupted = options->is_interrupted,
                          .user = options->user };
    return result == RF_OK ? rf_run_importer( &run, counts, log, error ) : result;
}

static RfResult convert_ply( const char* from, const char* to, const RfConvertOptions* options, RfModelCounts* counts, RfLog* log,
                             RfError* error )
{
    RfModel model;
    RfResult result = rf_read_ply( from, &model, log, error );
    if ( result == RF_OK )
        result = rf_apply_root_transform( &model, options->up == RF_UP_Z, options->scale, error );
    if ( result == RF_OK )
        result = rf_write_glb( to, &model, options->overwrite, error );
    if ( result == RF_OK )
        *counts = rf_count_model( &model );
    rf_destroy_model( &model );
    return result;
}

RfResult rf_convert_model( const char* source, const char* target, const RfConvertOptions* options, RfModelCounts* counts,
                           RfLog* log, RfError* error )
{
    char head[HEAD_BYTES];
    RfModelCounts found = { 0 };
    RF_TRY( check_files( source, target, options->overwrite, head, error ) );
    bool is_ply = memcmp( head, "ply", 3 ) == 0 && ( head[3] == '\n' || head[3] == '\r' || head[3] == ' ' );
    RfResult result = is_ply && !options->assimp ? convert_ply( source, target, options, &found, log, error )
                                                 : convert_by_assimp( source, target, options, &found, log, error );
    if ( counts != NULL )
        *counts = found;
    return result;
}
