// scripts/blender/export.py on what deforms and what changes its topology: every corner of the mesh that Blender evaluates in a
// frame is in the posed scene, with its normal, and nothing else is.
#include "support/blender_run.h"

#include "base/file.h"
#include "gltf/gltf.h"
#include "scene/deformation.h"
#include "scene/movement.h"
#include "scene/pose.h"

#define SIZE 2.0 // of each object
#define NEAR ( 1e-5 * SIZE )

typedef float Corner[6]; // position, normal

static int by_x( const void* a, const void* b )
{
    float x = ( (const float*)a )[0], y = ( (const float*)b )[0];
    return ( x > y ) - ( x < y );
}

static void add_corners( const RfTriangles* t, const RfMat4* matrix, Corner** all, size_t* count )
{
    *all = realloc( *all, ( *count + 3 * t->count + 1 ) * sizeof **all );
    assert_non_null( *all );
    for ( size_t i = 0; i < 3 * t->count; ++i )
    {
        float* out = ( *all )[( *count )++];
        for ( int part = 0; part < 2; ++part )
        {
            const float* from = ( part == 0 ? t->positions : t->normals ) + 3 * (size_t)t->indices[i];
            double local[3] = { (double)from[0], (double)from[1], (double)from[2] }, placed[3];
            rf_mat4_apply( matrix, local, part == 0 ? 1.0 : 0.0, placed );
            for ( int c = 0; c < 3; ++c )
                out[3 * part + c] = (float)placed[c];
            if ( part == 1 )
                rf_normalise( placed, 1.0, out + 3 );
        }
    }
}

// The corners of all triangles at a time, by x.
static size_t pose( const RfScene* scene, double time, Corner** all )
{
    AUTO_POSE posed = { 0 };
    RfError error;
    if ( rf_pose_scene( scene, time, &posed, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    size_t count = 0;
    RfMat4 one = rf_mat4_identity();
    add_corners( &scene->triangles, &one, all, &count );
    for ( int i = 0; i < posed.scene.placement_count; ++i )
    {
        const RfPlacement* placement = posed.scene.placements + i;
        if ( placement->shown )
            add_corners( &posed.scene.meshes[placement->mesh].triangles, &placement->matrix, all, &count );
    }
    qsort( *all, count, sizeof **all, by_x );
    return count;
}

// Is there one like it among those sorted by x?
static bool is_among( const float* wanted, const Corner* all, size_t count )
{
    size_t low = 0, high = count;
    while ( low < high )
    {
        size_t middle = ( low + high ) / 2;
        if ( (double)all[middle][0] < (double)wanted[0] - NEAR )
            low = middle + 1;
        else
            high = middle;
    }
    for ( ; low < count && (double)all[low][0] <= (double)wanted[0] + NEAR; ++low )
    {
        bool same = true;
        for ( int c = 0; c < 6; ++c )
            same = same && fabs( (double)all[low][c] - (double)wanted[c] ) <= ( c < 3 ? NEAR : 2e-3 );
        if ( same )
            return true;
    }
    return false;
}

static size_t count_missing( const Corner* wanted, size_t count, const Corner* all, size_t all_count, const char* what,
                             int frame )
{
    size_t missing = 0;
    for ( size_t i = 0; i < count; ++i )
    {
        bool found = is_among( wanted[i], all, all_count );
        if ( !found && missing++ < 3 )
            print_message( "frame %d: %s (%g %g %g), normal (%g %g %g)\n", frame, what, (double)wanted[i][0],
                           (double)wanted[i][1], (double)wanted[i][2], (double)wanted[i][3], (double)wanted[i][4],
                           (double)wanted[i][5] );
    }
    return missing;
}

static void expect_corners( const RfScene* scene, const uint8_t* data, size_t size )
{
    int frames = 0;
    for ( size_t at = 0; at < size; ++frames )
    {
        int32_t head[2];
        memcpy( head, data + at, sizeof head );
        size_t count = (size_t)head[1], all_count;
        Corner *wanted = malloc( count * sizeof *wanted ), *all = NULL;
        assert_true( wanted != NULL && count > 2000 );
        memcpy( wanted, data + at + sizeof head, count * sizeof *wanted );
        at += sizeof head + count * sizeof *wanted;
        qsort( wanted, count, sizeof *wanted, by_x );
        all_count = pose( scene, ( head[0] - 1 ) / 24.0, &all );
        assert_int_equal( count_missing( (const Corner*)wanted, count, (const Corner*)all, all_count, "lacks", head[0] ), 0 );
        assert_int_equal( count_missing( (const Corner*)all, all_count, (const Corner*)wanted, count, "has also", head[0] ), 0 );
        free( wanted );
        free( all );
    }
    assert_int_equal( frames, 3 );
}

// Exports a .blend, and expects the corners that Blender has.
static void expect_blenders( const char* name, RfScene* scene )
{
    cli_expect( blender_export( name, "" ), 0, NULL );
    char path[512];
    RfError error;
    snprintf( path, sizeof path, "%s.glb", name );
    *scene = convert_load( path );
    AUTO_FREE uint8_t* data;
    size_t size;
    snprintf( path, sizeof path, "%s/%s.bin", cli_folder(), name );
    assert_int_equal( rf_read_file( path, 1 << 30, &data, &size, &error ), RF_OK );
    expect_corners( scene, data, size );
}

// Of two keys a target each, and few for normals, which are not linear, in the place of one for each frame; of bones none that
// move vertices, unless they preserve the volume or the object has many instances.
static void expect_few_targets( const RfScene* scene )
{
    int skinned = 0, keyed = 0, others = 0;
    for ( int i = 0; i < scene->mesh_count; ++i )
    {
        const RfDeformation* deformation = scene->meshes[i].deformation;
        int moving = 0;
        assert_non_null( deformation );
        assert_true( deformation->target_count < 16 );
        for ( int k = 0; k < deformation->target_count; ++k )
            moving += deformation->targets[k].positions != NULL;
        skinned += deformation->joints != NULL && moving == 0;
        keyed += deformation->joints == NULL && moving == 2;
        others += deformation->joints == NULL && moving > 2;
    }
    assert_int_equal( scene->movement->skin_count, 2 ); // the tube is there twice
    assert_int_equal( skinned, 1 );
    assert_int_equal( keyed, 1 );
    assert_int_equal( others, 2 );
}

BLENDER_TEST( test_shapes_are_blenders )
{
    blender_make( "shapes" );
    RfScene scene;
    expect_blenders( "shapes", &scene );
    assert_true( scene.mesh_count < 40 ); // none for each frame of what instances show
    rf_destroy_scene( &scene );
    expect_blenders( "rigs", &scene );
    expect_few_targets( &scene );
    rf_destroy_scene( &scene );
    // limits that this scene exceeds
#define LIMITED( limit )                                                                                                         \
    BLENDER "shapes.blend --python-expr 'import sys; sys.path.insert(0, \"" REFRAME_SOURCE_DIR                                   \
            "/scripts\"); from blender import shapes; shapes." limit "' -P " BLENDER_SCRIPT "few.glb"
    const CliResult* done = cli_run( LIMITED( "MOST_CORNERS = 20" ) );
    assert_int_equal( done->status, 1 );
    assert_non_null( strstr( done->err,
                             "loss: 'array': keeps its shape from frame 3 on: meshes of all topologies have more than 0 million "
                             "corners: export fewer frames\n" ) );
    done = cli_run( LIMITED( "MOST_BYTES = 2000" ) );
    assert_int_equal( done->status, 1 );
    assert_non_null( strstr( done->err,
                             "loss: 'skin': keeps its shape from frame 2 on: the shapes of all objects take more than 0 GiB: "
                             "export fewer frames\n" ) );
}
