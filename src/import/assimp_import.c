// From assimp's scene to a model, and the program around it,
//
//     reframe-import FILE BYTES SECONDS file|y|z SCALE accept|refuse
//
// which writes FILE as .glb to standard output. Started by `reframe convert`. It limits its own memory and time, so that whatever
// a file does to assimp affects only this process.
#include "import/assimp_import.h"

#include "base/remedy.h"
#include "base/try.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/version.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

char* rf_import_text( const struct aiString* text ) { return text->length > 0 ? strdup( text->data ) : NULL; }

static RfResult fail_import( const char* reason, RfError* error )
{
    if ( strstr( reason, "No suitable reader" ) != NULL )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "unknown format: OBJ, PLY, FBX and Collada are converted" );
    return rf_fail( error, RF_ERROR_FORMAT, "cannot be read (%s): export it as glTF (.glb) from the program it came from",
                    *reason != 0 ? reason : "the importer gives no reason" );
}

// A whole number among what the file says of itself; `otherwise` where it is not there.
static int number_of_file( const struct aiScene* scene, const char* name, int otherwise )
{
    const struct aiMetadata* data = scene->mMetaData;
    for ( unsigned i = 0; data != NULL && i < data->mNumProperties; ++i )
    {
        const struct aiMetadataEntry* entry = data->mValues + i;
        if ( strcmp( data->mKeys[i].data, name ) == 0 && entry->mType == AI_INT32 && entry->mData != NULL )
            memcpy( &otherwise, entry->mData, sizeof otherwise );
    }
    return otherwise;
}

// The unit in which an FBX file counts, which assimp would multiply in by taking its matrices apart.
static void find_unit( RfImport* import )
{
    const struct aiMetadata* data = import->scene->mMetaData;
    for ( unsigned i = 0; data != NULL && import->source->format == RF_SOURCE_FBX && i < data->mNumProperties; ++i )
    {
        const struct aiMetadataEntry* entry = data->mValues + i;
        float single = 0.0f;
        double value = 0.0;
        if ( strcmp( data->mKeys[i].data, "UnitScaleFactor" ) != 0 || entry->mData == NULL )
            continue;
        if ( entry->mType == AI_FLOAT )
            memcpy( &single, entry->mData, sizeof single );
        else if ( entry->mType == AI_DOUBLE )
            memcpy( &value, entry->mData, sizeof value );
        value = single != 0.0f ? (double)single : value;
        if ( value > 0.0 && isfinite( value ) )
            import->source->unit = 0.01 * value;
    }
}

// assimp turns Collada files to y up; FBX files only from 5.4 on, by a rotation of the root. Does that for older ones, or
// takes it out where the user says what is up.
static void turn_fbx_axes( RfImport* import )
{
    static const char* const names[3][2] = { { "CoordAxis", "CoordAxisSign" },
                                             { "UpAxis", "UpAxisSign" },
                                             { "FrontAxis", "FrontAxisSign" } };
    if ( import->source->format != RF_SOURCE_FBX )
        return;
    if ( ( 100 * aiGetVersionMajor() + aiGetVersionMinor() >= 504 ) == import->up_of_file )
        return;
    float turn[3][3] = { { 0 } }; // the axes are the rows of the rotation, and the columns of its inverse
    for ( int i = 0; i < 3; ++i )
    {
        int axis = number_of_file( import->scene, names[i][0], i );
        if ( axis < 0 || axis > 2 )
            return;
        float sign = number_of_file( import->scene, names[i][1], 1 ) < 0 ? -1.0f : 1.0f;
        turn[import->up_of_file ? i : axis][import->up_of_file ? axis : i] = sign;
    }
    float* m = &import->scene->mRootNode->mTransformation.a1;
    for ( int row = 0; row < 3; ++row, m += 4 )
    {
        const float old[3] = { m[0], m[1], m[2] };
        for ( int i = 0; i < 3; ++i )
            m[i] = old[0] * turn[0][i] + old[1] * turn[1][i] + old[2] * turn[2][i];
    }
}

static void restore_name( const RfImport* import, char** name )
{
    const char* old = *name != NULL ? rf_name_in_file( import->source, *name ) : NULL;
    char* copy = old != *name ? strdup( old ) : NULL;
    if ( copy == NULL )
        return;
    free( *name );
    *name = copy;
}

// Names that were made unique for assimp become again what they were.
static void restore_names( const RfImport* import )
{
    const RfModel* model = import->model;
    for ( int i = 0; i < model->node_count; ++i )
        restore_name( import, &model->nodes[i].name );
    for ( int i = 0; i < model->mesh_count; ++i )
    {
        restore_name( import, &model->meshes[i].name );
        for ( int k = 0; k < model->meshes[i].morph_count; ++k )
            restore_name( import, &model->meshes[i].morphs[k].name );
    }
    for ( int i = 0; i < model->camera_count; ++i )
        restore_name( import, &model->cameras[i].name );
    for ( int i = 0; i < model->light_count; ++i )
        restore_name( import, &model->lights[i].name );
}

static RfResult take_all( RfImport* import, RfError* error )
{
    find_unit( import );
    turn_fbx_axes( import );
    if ( import->turned_again && import->source->format == RF_SOURCE_COLLADA )
        rf_warn( import->log, "the file says which of its axes points up, and is turned to y: it is turned once more" );
    RF_TRY( rf_import_materials( import, error ) );
    if ( import->lost[0] != 0 && !import->accepts_losses )
        return rf_advise( rf_fail( error, RF_ERROR_IO, "%s", import->lost ), RF_REMEDY_ACCEPT_LOSSES, 0, error );
    RF_TRY( rf_import_meshes( import, error ) );
    RF_TRY( rf_import_nodes( import, error ) );
    rf_import_cameras( import );
    rf_import_lights( import );
    RF_TRY( rf_import_skins( import, error ) );
    RF_TRY( rf_import_animations( import, error ) );
    restore_names( import );
    if ( import->model->mesh_count == 0 )
        return rf_fail( error, RF_ERROR_SCENE, "has no triangles: nothing to convert" );
    return RF_OK;
}

// Imports a whole file. Messages do not name the file: the caller does.
static RfResult import_by_assimp( char** argv, RfModel* model, RfLog* log, RfError* error )
{
    const char* path = argv[1];
    RfSource source;
    RfImport import = { .source = &source,
                        .model = model,
                        .log = log,
                        .accepts_losses = strcmp( argv[6], "accept" ) == 0,
                        .up_of_file = strcmp( argv[4], "file" ) == 0,
                        .turned_again = strcmp( argv[4], "z" ) == 0,
                        .cutter = { .steps = RF_CUT_STEPS } };
    RfResult result = rf_open_source( path, &source, log, error );
    // points and lines stay in their meshes and are counted there; equal vertices become one later, all that they have compared
    import.scene = result == RF_OK ? rf_read_source( &source, 0 ) : NULL;
    if ( result == RF_OK && import.scene == NULL )
        result = fail_import( aiGetErrorString(), error );
    else if ( result == RF_OK && import.scene->mRootNode == NULL )
        result = fail_import( "it is empty", error );
    if ( result == RF_OK )
    {
        import.meshes = malloc( ( (size_t)import.scene->mNumMeshes + 1 ) * sizeof *import.meshes );
        import.origins = calloc( (size_t)import.scene->mNumMeshes + 1, sizeof *import.origins );
    }
    if ( result == RF_OK )
        result = import.meshes == NULL || import.origins == NULL ? rf_fail( error, RF_ERROR_MEMORY, RF_IMPORT_MEMORY )
                                                                 : take_all( &import, error );
    free( import.meshes );
    free( import.origins );
    free( import.posed );
    free( import.image_names );
    rf_free_cutter( &import.cutter );
    rf_close_source( &source );
    if ( import.scene != NULL )
        aiReleaseImport( import.scene );
    return result;
}

#define _DEFAULT_SOURCE // setrlimit, prctl

#include "import/assimp_import.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#define WARNING_LIMIT 64

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
    fprintf( stderr, "counts: %llu %d %d %d %d %d %d %d %d %d\n", c.triangles, c.meshes, c.nodes, c.materials, c.images,
             c.cameras, c.lights, c.skins, c.morphs, c.animations );
}

static RfResult import_to( RfAtomicFile* out, char** argv, RfError* error )
{
    RfModel model = { 0 };
    int warnings = 0;
    RfLog log = { .fn = print_warning, .user = &warnings };
    double scale;
    unsigned long long bits = strtoull( argv[5], NULL, 16 );
    memcpy( &scale, &bits, sizeof scale );
    RfResult result = import_by_assimp( argv, &model, &log, error );
    if ( result == RF_OK )
        result = rf_apply_root_transform( &model, argv[4][0] == 'z', scale, error );
    if ( result == RF_OK )
        result = rf_append_glb( out, &model, error );
    if ( result == RF_OK )
        print_counts( &model );
    rf_destroy_model( &model );
    return result;
}

#ifdef REFRAME_SANITIZED
// assimp does not free what it reads of animated weights.
const char* __lsan_default_suppressions( void );
const char* __lsan_default_suppressions( void ) { return "leak:libassimp\n"; }
#endif

int main( int argc, char** argv )
{
    if ( argc != 7 )
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
    fprintf( stderr, "%s: %s\n", error.remedy == RF_REMEDY_ACCEPT_LOSSES ? "lost" : "error", error.text );
    return 1;
}
