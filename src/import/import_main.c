// reframe-import FILE BYTES SECONDS y|z SCALE: imports FILE by assimp and writes it as .glb to
// standard output. Started by `reframe convert`. It limits its own memory and time, so that
// whatever a file does to assimp affects only this process.
#define _DEFAULT_SOURCE // setrlimit, prctl

#include "convert/glb_write.h"
#include "convert/model.h"
#include "import/assimp_import.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#define WARNING_LIMIT 16

static void set_limit( int resource, unsigned long long value )
{
    struct rlimit limit;
    if ( getrlimit( resource, &limit ) != 0 )
        return;
    if ( limit.rlim_max == RLIM_INFINITY || value < limit.rlim_max )
        limit.rlim_max = value;
    limit.rlim_cur = limit.rlim_max;
    setrlimit( resource, &limit );
}

static void set_limits( unsigned long long bytes, unsigned long long seconds )
{
    prctl( PR_SET_PDEATHSIG, SIGKILL );
    set_limit( RLIMIT_CORE, 0 );
    set_limit( RLIMIT_CPU, seconds + 1 );
#ifndef REFRAME_SANITIZED // sanitizers reserve terabytes of address space
    set_limit( RLIMIT_AS, bytes );
#else
    (void)bytes;
#endif
}

static void print_warning( void* user, const char* line )
{
    int* count = user;
    if ( ++*count < WARNING_LIMIT )
        fprintf( stderr, "warning: %s\n", line );
    else if ( *count == WARNING_LIMIT )
        fprintf( stderr, "warning: and more of the kind\n" );
}

static void print_counts( const RfModel* model )
{
    RfModelCounts c = rf_count_model( model );
    fprintf( stderr, "counts: %llu %d %d %d %d %d %d\n", c.triangles, c.meshes, c.nodes, c.materials, c.images, c.cameras,
             c.lights );
}

static RfResult import_to( RfAtomicFile* out, char** argv, RfError* error )
{
    RfModel model = { 0 };
    int warnings = 0;
    RfLog log = { .fn = print_warning, .user = &warnings };
    double scale;
    unsigned long long bits = strtoull( argv[5], NULL, 16 );
    memcpy( &scale, &bits, sizeof scale );
    RfResult result = rf_import_by_assimp( argv[1], &model, &log, error );
    if ( result == RF_OK )
        result = rf_apply_root_transform( &model, argv[4][0] == 'z', scale, error );
    if ( result == RF_OK )
        result = rf_append_glb( out, &model, error );
    if ( result == RF_OK )
        print_counts( &model );
    rf_destroy_model( &model );
    return result;
}

int main( int argc, char** argv )
{
    if ( argc != 6 )
    {
        fprintf( stderr, "error: reframe-import is started by reframe convert, not by hand\n" );
        return 2;
    }
    set_limits( strtoull( argv[2], NULL, 10 ), strtoull( argv[3], NULL, 10 ) );
    // keeps assimp's own output out of the result
    RfAtomicFile out = { .path = "its .glb", .fd = dup( 1 ), .folder = -1 };
    int nothing = open( "/dev/null", O_WRONLY );
    if ( out.fd < 0 || nothing < 0 || dup2( nothing, 1 ) < 0 )
        return 1;
    RfError error;
    if ( import_to( &out, argv, &error ) == RF_OK )
        return 0;
    fprintf( stderr, "error: %s\n", error.text );
    return 1;
}
