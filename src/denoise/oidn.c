// Finds, loads and runs Open Image Denoise.
#define _GNU_SOURCE // dladdr
#include "denoise/oidn.h"

#include "base/remedy.h"
#include "base/try.h"

#include <dlfcn.h>
#include <glob.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Of the interface of version 2.
enum
{
    DEVICE_CPU = 1,
    FORMAT_FLOAT3 = 3,
    OLDEST = 20000,
    MOST_MEGABYTES = 500
};

#define FUNCTIONS( X )                                                                                                           \
    X( void*, oidnNewDevice, (int))                                                                                              \
    X( void, oidnSetDeviceInt, (void*, const char*, int))                                                                        \
    X( void, oidnSetDeviceBool, (void*, const char*, bool))                                                                      \
    X( int, oidnGetDeviceInt, (void*, const char*))                                                                              \
    X( void, oidnCommitDevice, (void*))                                                                                          \
    X( int, oidnGetDeviceError, (void*, const char**))                                                                           \
    X( void, oidnReleaseDevice, (void*))                                                                                         \
    X( void*, oidnNewFilter, (void*, const char*))                                                                               \
    X( void, oidnSetSharedFilterImage, ( void*, const char*, void*, int, size_t, size_t, size_t, size_t, size_t ) )              \
    X( void, oidnSetFilterBool, (void*, const char*, bool))                                                                      \
    X( void, oidnSetFilterInt, (void*, const char*, int))                                                                        \
    X( void, oidnSetFilterFloat, (void*, const char*, float))                                                                    \
    X( void, oidnCommitFilter, (void*))                                                                                          \
    X( void, oidnExecuteFilter, (void*))                                                                                         \
    X( void, oidnReleaseFilter, (void*))

#define MEMBER( type, name, arguments ) type( *name ) arguments;

struct RfDenoiser
{
    void *library, *device;
    pthread_mutex_t lock; // of what follows: a render judges frames while finished ones are written
    void* filter;         // kept for pictures alike: its memory is large
    RfOidnImages last;    // what it was made for
    FUNCTIONS( MEMBER )
    char name[64];
};

typedef void Function( void );

// The functions of the library; NULL, or the name of one that it lacks.
static const char* load_functions( RfDenoiser* d )
{
    // POSIX: a pointer to an object holds one to a function
#define LOAD( type, name, arguments )                                                                                            \
    {                                                                                                                            \
        void* found = dlsym( d->library, #name );                                                                                \
        memcpy( &d->name, &found, sizeof found );                                                                                \
        if ( found == NULL )                                                                                                     \
            return #name;                                                                                                        \
    }
    FUNCTIONS( LOAD )
#undef LOAD
    return NULL;
}

// Where a library may be: behind the folder $HOME, or of caches; the newest first within each.
static const char s_cached[] = "%s/reframe/denoiser/lib/libOpenImageDenoise.so.2"; // scripts/install-packages --denoiser
static const char* const s_places[] = {
    "%s/.cache/reframe/denoiser/lib/libOpenImageDenoise.so.2",
    "/usr/share/blender/lib/libOpenImageDenoise.so.2",
    "/opt/blender*/lib/libOpenImageDenoise.so.2",
    "/snap/blender/current/lib/libOpenImageDenoise.so.2",
    "%s/blender*/lib/libOpenImageDenoise.so.2",
    "%s/.local/lib/python3*/site-packages/pyoidn/oidn/lib/libOpenImageDenoise.so.2",
    "%s/.local/lib/python3*/site-packages/bpy/lib/libOpenImageDenoise.so.2",
    "/usr/local/lib/python3*/*-packages/pyoidn/oidn/lib/libOpenImageDenoise.so.2",
    "/usr/local/lib/python3*/*-packages/bpy/lib/libOpenImageDenoise.so.2",
};

static void* open_place( const char* place, const char* home )
{
    char pattern[4096];
    glob_t found;
    void* library = NULL;
    snprintf( pattern, sizeof pattern, place, home ); // NOLINT: the formats are ours
    if ( glob( pattern, 0, NULL, &found ) == 0 )
    {
        for ( size_t i = found.gl_pathc; i > 0 && library == NULL; --i )
            library = dlopen( found.gl_pathv[i - 1], RTLD_NOW | RTLD_LOCAL );
    }
    globfree( &found );
    return library;
}

static RfResult find_library( const char* name, void** library, RfError* error )
{
    const char *asked = name != NULL ? name : getenv( "REFRAME_OIDN" ), *home = getenv( "HOME" ),
               *cache = getenv( "XDG_CACHE_HOME" );
    if ( asked != NULL && asked[0] != '\0' )
    {
        char path[4096]; // a name without a folder is that of a file here, before one of the system
        snprintf( path, sizeof path, "%s%s", strchr( asked, '/' ) == NULL && access( asked, R_OK ) == 0 ? "./" : "", asked );
        *library = dlopen( path, RTLD_NOW | RTLD_LOCAL );
        return *library != NULL ? RF_OK
                                : rf_fail( error, RF_ERROR_UNSUPPORTED, "the denoiser cannot be loaded: %.800s", dlerror() );
    }
    *library = dlopen( "libOpenImageDenoise.so.2", RTLD_NOW | RTLD_LOCAL );
    if ( *library == NULL && cache != NULL )
        *library = open_place( s_cached, cache );
    for ( size_t i = 0; i < sizeof s_places / sizeof s_places[0] && *library == NULL; ++i )
        *library = open_place( s_places[i], home != NULL ? home : "" );
    if ( *library != NULL )
        return RF_OK;
    return rf_advise( rf_fail( error, RF_ERROR_UNSUPPORTED, "Open Image Denoise 2 is not there" ), RF_REMEDY_DENOISER, 0, error );
}

static RfResult check_device( const RfDenoiser* d, RfError* error )
{
    const char* text = NULL;
    return d->oidnGetDeviceError( d->device, &text ) == 0
               ? RF_OK
               : rf_fail( error, RF_ERROR_UNSUPPORTED, "Open Image Denoise: %.500s", text != NULL ? text : "it failed" );
}

static RfResult start( RfDenoiser* d, int threads, RfError* error )
{
    Dl_info info = { 0 };
    const char* missing = load_functions( d );
    if ( missing != NULL )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "the denoiser's library is no Open Image Denoise 2: it lacks %s", missing );
    d->device = d->oidnNewDevice( DEVICE_CPU );
    if ( d->device == NULL )
        return check_device( d, error );
    if ( threads > 0 )
        d->oidnSetDeviceInt( d->device, "numThreads", threads );
    d->oidnSetDeviceBool( d->device, "setAffinity", false );
    d->oidnCommitDevice( d->device );
    RF_TRY( check_device( d, error ) );
    int version = d->oidnGetDeviceInt( d->device, "version" );
    dladdr( *(void**)&d->oidnNewDevice, &info );
    if ( version < OLDEST )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%.300s: is Open Image Denoise %d.%d, but 2.0 or later is needed",
                        info.dli_fname != NULL ? info.dli_fname : "the library", version / 10000, version / 100 % 100 );
    snprintf( d->name, sizeof d->name, "Open Image Denoise %d.%d.%d", version / 10000, version / 100 % 100, version % 100 );
    return RF_OK;
}

RfResult rf_open_denoiser( const char* library, int threads, RfDenoiser** denoiser, RfError* error )
{
    RfDenoiser* d = calloc( 1, sizeof *d );
    *denoiser = NULL;
    if ( d == NULL || pthread_mutex_init( &d->lock, NULL ) != 0 )
    {
        free( d );
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the denoiser" );
    }
    RfResult result = find_library( library, &d->library, error );
    if ( result == RF_OK )
        result = start( d, threads, error );
    if ( result == RF_OK )
        *denoiser = d;
    else
        rf_close_denoiser( d );
    return result;
}

void rf_close_denoiser( RfDenoiser* d )
{
    if ( d == NULL )
        return;
    if ( d->filter != NULL )
        d->oidnReleaseFilter( d->filter );
    if ( d->device != NULL )
        d->oidnReleaseDevice( d->device );
    pthread_mutex_destroy( &d->lock );
    free( d ); // the library stays: its threads may still run
}

const char* rf_denoiser_name( const RfDenoiser* d ) { return d->name; }

// The library only reads the inputs.
static void set_image( RfDenoiser* d, const char* name, const float* pixels, const RfOidnImages* size )
{
    if ( pixels != NULL )
        d->oidnSetSharedFilterImage( d->filter, name, (void*)pixels, FORMAT_FLOAT3, (size_t)size->width, (size_t)size->height, 0,
                                     0, 0 );
}

static bool are_alike( const RfOidnImages* a, const RfOidnImages* b )
{
    return a->width == b->width && a->height == b->height && ( a->albedo != NULL ) == ( b->albedo != NULL ) &&
           ( a->normal != NULL ) == ( b->normal != NULL );
}

static RfResult make_filter( RfDenoiser* d, RfError* error )
{
    if ( d->filter != NULL )
        d->oidnReleaseFilter( d->filter );
    d->filter = d->oidnNewFilter( d->device, "RT" );
    if ( d->filter == NULL )
        return check_device( d, error );
    d->oidnSetFilterBool( d->filter, "hdr", true );
    d->oidnSetFilterInt( d->filter, "maxMemoryMB", MOST_MEGABYTES );
    return RF_OK;
}

static RfResult run_filter( RfDenoiser* d, const RfOidnImages* images, float* clean, RfError* error )
{
    if ( d->filter == NULL || !are_alike( images, &d->last ) )
        RF_TRY( make_filter( d, error ) );
    d->last = *images;
    set_image( d, "color", images->colour, images );
    set_image( d, "albedo", images->albedo, images );
    set_image( d, "normal", images->normal, images );
    set_image( d, "output", clean, images );
    d->oidnSetFilterFloat( d->filter, "inputScale", images->scale );
    d->oidnCommitFilter( d->filter );
    d->oidnExecuteFilter( d->filter );
    return check_device( d, error );
}

RfResult rf_run_oidn( RfDenoiser* d, const RfOidnImages* images, float* clean, RfError* error )
{
    pthread_mutex_lock( &d->lock );
    RfResult result = run_filter( d, images, clean, error );
    pthread_mutex_unlock( &d->lock );
    return result;
}
