#include "support/scene_files.h"

#include "gltf/gltf.h"
#include "scene/placement.h"
#include "support/cli_run.h"
#include "support/image_files.h"
#include "support/test.h"

#include <unistd.h>

GltfFolder make_folder( void )
{
    GltfFolder folder = { .path = "/tmp/reframe-gltf-XXXXXX" };
    if ( mkdtemp( folder.path ) == NULL )
        abort();
    return folder;
}

const char* folder_file( GltfFolder* folder, const char* name )
{
    snprintf( folder->file, sizeof folder->file, "%s/%s", folder->path, name );
    return folder->file;
}

const char* write_bytes( GltfFolder* folder, const char* name, const void* bytes, size_t size )
{
    FILE* file = fopen( folder_file( folder, name ), "wb" );
    if ( file == NULL || fwrite( bytes, 1, size, file ) != size || fclose( file ) != 0 )
        abort();
    return folder->file;
}

void remove_folder( GltfFolder* folder )
{
    static const char* const s_names[] = { "a.gltf", "a.glb", "a.bin", "b c.bin" };
    for ( size_t i = 0; i < sizeof s_names / sizeof s_names[0]; ++i )
        unlink( folder_file( folder, s_names[i] ) );
    rmdir( folder->path );
}

__attribute__( ( format( printf, 3, 4 ) ) ) static void append_text( char* text, size_t size, const char* format, ... )
{
    size_t used = strlen( text );
    va_list args;
    va_start( args, format );
    int n = vsnprintf( text + used, size - used, format, args );
    va_end( args );
    if ( n < 0 || (size_t)n >= size - used )
        abort();
}

int add_gltf_accessor( GltfBuilder* b, int component_type, const char* type, int count, const void* data, size_t size,
                       const char* more )
{
    if ( b->bin_size + size + 4 > sizeof b->bin )
        abort();
    memcpy( b->bin + b->bin_size, data, size );
    const char* comma = b->count > 0 ? "," : "";
    append_text( b->views, sizeof b->views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", comma, b->bin_size, size );
    append_text( b->accessors, sizeof b->accessors, "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%d,\"type\":\"%s\"%s}",
                 comma, b->count, component_type, count, type, more );
    b->bin_size += ( size + 3 ) / 4 * 4;
    return b->count++;
}

int add_gltf_floats( GltfBuilder* b, const char* type, int components, int count, const float* data )
{
    return add_gltf_accessor( b, 5126, type, count, data, (size_t)( components * count ) * sizeof *data, "" );
}

int add_gltf_u16( GltfBuilder* b, int count, const uint16_t* data )
{
    return add_gltf_accessor( b, 5123, "SCALAR", count, data, (size_t)count * sizeof *data, "" );
}

const char* build_gltf_json( GltfBuilder* b, const char* uri, const char* rest )
{
    b->json[0] = 0;
    append_text( b->json, sizeof b->json, "{\"asset\":{\"version\":\"2.0\"}" );
    if ( b->count > 0 )
    {
        append_text( b->json, sizeof b->json, ",\"buffers\":[{\"byteLength\":%zu", b->bin_size );
        if ( uri != NULL )
            append_text( b->json, sizeof b->json, ",\"uri\":\"%s\"", uri );
        append_text( b->json, sizeof b->json, "}],\"bufferViews\":[%s],\"accessors\":[%s]", b->views, b->accessors );
    }
    append_text( b->json, sizeof b->json, "%s%s}", rest[0] != 0 ? "," : "", rest );
    return b->json;
}

char* gltf_base64( const uint8_t* bytes, size_t size )
{
    static const char s_digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char* text = calloc( size / 3 * 4 + 8, 1 );
    char* out = text;
    for ( size_t i = 0; text != NULL && i < size; i += 3 )
    {
        uint32_t word = (uint32_t)bytes[i] << 16;
        word |= i + 1 < size ? (uint32_t)bytes[i + 1] << 8 : 0;
        word |= i + 2 < size ? bytes[i + 2] : 0;
        for ( int d = 0; d < 4; ++d )
            *out++ = i + (size_t)d > size ? '=' : s_digits[word >> ( 18 - 6 * d ) & 63];
    }
    return text;
}

const char* write_gltf( GltfBuilder* b, GltfFolder* folder, const char* rest )
{
    char* data = gltf_base64( b->bin, b->bin_size );
    char* uri = calloc( strlen( data ) + 64, 1 );
    sprintf( uri, "data:application/octet-stream;base64,%s", data );
    build_gltf_json( b, uri, rest );
    free( data );
    free( uri );
    return write_bytes( folder, "a.gltf", b->json, strlen( b->json ) );
}

static void put_u32( uint8_t* at, uint32_t value )
{
    for ( int i = 0; i < 4; ++i )
        at[i] = (uint8_t)( value >> ( 8 * i ) );
}

uint8_t* build_glb( GltfBuilder* b, const char* rest, size_t* size )
{
    build_gltf_json( b, NULL, rest );
    size_t length = strlen( b->json ), padded = ( length + 3 ) / 4 * 4;
    *size = 12 + 8 + padded + 8 + b->bin_size;
    uint8_t* bytes = calloc( *size, 1 );
    memcpy( bytes, "glTF", 4 );
    put_u32( bytes + 4, 2 );
    put_u32( bytes + 8, (uint32_t)*size );
    put_u32( bytes + 12, (uint32_t)padded );
    memcpy( bytes + 16, "JSON", 4 );
    memset( bytes + 20, ' ', padded );
    memcpy( bytes + 20, b->json, length );
    put_u32( bytes + 20 + padded, (uint32_t)b->bin_size );
    memcpy( bytes + 24 + padded, "BIN\0", 4 );
    memcpy( bytes + 28 + padded, b->bin, b->bin_size );
    return bytes;
}

size_t mutate_bytes( uint8_t* bytes, size_t size, uint64_t number )
{
    static const char s_swaps[] = "0123456789-.eE\"[]{},:tfn ";
    uint64_t state = number * 0x9e3779b97f4a7c15ull + 1;
    int changes = 0, wanted = 1 + (int)( number % 4 );
    for ( int tries = 0; changes < wanted && tries < 1000; ++tries )
    {
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
        size_t at = (size_t)( ( state >> 16 ) % size );
        if ( number % 3 == 0 )
            bytes[at] ^= (uint8_t)( 1u << ( state & 7 ) );
        else if ( number % 3 == 1 && bytes[at] >= '0' && bytes[at] <= '9' )
            bytes[at] = (uint8_t)s_swaps[( state >> 8 ) % 15];
        else if ( number % 3 == 2 && at < size )
            bytes[at] = (uint8_t)s_swaps[( state >> 8 ) % ( sizeof s_swaps - 1 )];
        else
            continue;
        changes += 1;
    }
    if ( number % 17 == 0 )
        size = (size_t)( ( state >> 12 ) % size );
    if ( number % 5 != 0 && size >= 12 )
    {
        memcpy( bytes, "glTF\2\0\0\0", 8 );
        put_u32( bytes + 8, (uint32_t)size );
    }
    return size;
}

// ---- gltf checks ----

GltfFolder gltf_folder;
char gltf_warnings[4096];

static void keep_warning( void* user, const char* line )
{
    (void)user;
    size_t used = strlen( gltf_warnings );
    snprintf( gltf_warnings + used, sizeof gltf_warnings - used, "%s\n", line );
}

RfScene gltf_load( const char* path )
{
    RfScene scene = gltf_load_with( path, &( RfGltfOptions ){ 0 } );
    assert_string_equal( scene.path, path );
    return scene;
}

RfScene gltf_load_built( GltfBuilder* b, const char* rest ) { return gltf_load( write_gltf( b, &gltf_folder, rest ) ); }

RfScene gltf_load_with( const char* path, const RfGltfOptions* options )
{
    RfLog log = { .fn = keep_warning };
    RfScene scene;
    RfError error = { 0 };
    gltf_warnings[0] = 0;
    if ( rf_load_gltf_with( path, options, &scene, &log, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return scene;
}

void gltf_refuse_built( GltfBuilder* b, const char* rest, const char* part )
{
    RfScene scene;
    RfError error = { 0 };
    RfResult result = rf_load_gltf( write_gltf( b, &gltf_folder, rest ), &scene, NULL, &error );
    if ( result == RF_OK || strstr( error.text, part ) == NULL )
        fail_msg( "wants an error with '%s', got '%s'", part, result == RF_OK ? "none" : error.text );
    assert_null( strchr( error.text, '\n' ) );
    rf_destroy_scene( &scene );
}

void gltf_assert_near( float got, double want )
{
    if ( ( fabs( (double)got - want ) <= 1e-6 * fmax( 1.0, fabs( want ) ) ) == false )
        fail_msg( "got %.9g, want %.9g", (double)got, want );
}

void gltf_assert_three( const float* got, double x, double y, double z )
{
    gltf_assert_near( got[0], x );
    gltf_assert_near( got[1], y );
    gltf_assert_near( got[2], z );
}

void gltf_assert_rgb( RfVec3 got, double r, double g, double b ) { gltf_assert_three( &got.x, r, g, b ); }

void gltf_assert_corner( const RfScene* scene, int corner, double x, double y, double z )
{
    gltf_assert_three( scene->triangles.positions + 3 * (size_t)scene->triangles.indices[corner], x, y, z );
}

void gltf_assert_normal( const RfScene* scene, int corner, double x, double y, double z )
{
    gltf_assert_three( scene->triangles.normals + 3 * (size_t)scene->triangles.indices[corner], x, y, z );
}

void gltf_assert_warned( const char* text )
{
    if ( strstr( gltf_warnings, text ) == NULL )
        fail_msg( "no warning has '%s': %s", text, gltf_warnings );
}

int gltf_enter( void** state )
{
    (void)state;
    gltf_folder = make_folder();
    return 0;
}

int gltf_leave( void** state )
{
    (void)state;
    remove_folder( &gltf_folder );
    return 0;
}

// ---- what moves ----

void gltf_find_placed_corner( const RfScene* scene, uint32_t triangle, int corner, double out[3] )
{
    RfTriangleAt at = rf_locate_triangle( scene, triangle );
    const float* p = at.triangles->positions + 3 * (size_t)at.triangles->indices[3 * (size_t)at.index + (size_t)corner];
    double local[3] = { (double)p[0], (double)p[1], (double)p[2] };
    if ( at.placement != NULL )
        rf_mat4_apply( &at.placement->matrix, local, 1.0, out );
    else
        memcpy( out, local, sizeof local );
}

void gltf_assert_placed_corner( const RfScene* scene, uint32_t triangle, int corner, double x, double y, double z )
{
    double at[3];
    gltf_find_placed_corner( scene, triangle, corner, at );
    gltf_assert_near( (float)at[0], x );
    gltf_assert_near( (float)at[1], y );
    gltf_assert_near( (float)at[2], z );
}

const float* gltf_placed_normal( const RfScene* scene, uint32_t triangle, int corner )
{
    RfTriangleAt at = rf_locate_triangle( scene, triangle );
    return at.triangles->normals + 3 * (size_t)at.triangles->indices[3 * (size_t)at.index + (size_t)corner];
}

RfPosedScene gltf_pose_at( const RfScene* scene, double time )
{
    RfPosedScene pose = { 0 };
    RfError error = { 0 };
    if ( rf_pose_scene( scene, time, &pose, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return pose;
}

void gltf_assert_unit_normals( const RfScene* scene )
{
    for ( int m = 0; m < scene->mesh_count; ++m )
    {
        const RfTriangles* t = &scene->meshes[m].triangles;
        for ( size_t v = 0; scene->meshes[m].deformation == NULL && t->count > 0 && v < t->vertex_count; ++v )
        {
            const float* n = t->normals + 3 * v;
            gltf_assert_near( n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0 );
        }
    }
}

// ---- json room ----

// A triangle of vase before a still and a moving camera; materials of each kind.
static const char s_gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]%s}],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
    "\"nodes\":[{\"name\":\"Eye\",\"camera\":0},{\"name\":\"Side\",\"camera\":0,\"translation\":[1,0,0]},{\"mesh\":0}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":2}]}],"
    "\"materials\":[{\"name\":\"vase\",\"extras\":{\"reframe\":{\"bsdf\":\"phong\",\"diffuse\":[0.2,0.1,0.1],"
    "\"specular\":[0.5,0.5,0.5],\"exponent\":60}}},"
    "{\"name\":\"wood floor\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0.125,1],\"metallicFactor\":0},"
    "\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0}}},"
    "{\"name\":\"lamp\",\"emissiveFactor\":[1,1,1]},{},{\"name\":\"lamp\",\"emissiveFactor\":[0,1,0]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[-1,-1,-2],\"max\":[1,1,-2]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AACAvwAAgL8AAADAAACAPwAAgL8AAADAAAAAAAAAgD8AAADA\"}]}";

void write_text( const char* name, const char* text ) { cli_write( name, text, strlen( text ) ); }

void write_room( const char* extras )
{
    char text[4096];
    snprintf( text, sizeof text, s_gltf, extras );
    write_text( "room.gltf", text );
}

RfResult load_named( const char* name, RfScene* scene, RfError* error )
{
    return rf_load_scene( cli_path( name ), scene, NULL, error );
}

RfResult try_members( const char* members, RfScene* scene, RfError* error )
{
    char text[4096];
    snprintf( text, sizeof text, "{\"scene\":\"room.gltf\"%s%s}", members[0] != 0 ? "," : "", members );
    write_text( "scene.json", text );
    return load_named( "scene.json", scene, error );
}

// ---- camera path checks ----

static RfResult load( const char* text, RfCamera* camera, RfError* error )
{
    char path[256];
    cli_write( "path.json", text, strlen( text ) );
    snprintf( path, sizeof path, "%s/path.json", cli_folder() );
    return rf_load_camera( path, camera, error );
}

RfCamera load_path( const char* text )
{
    RfCamera camera;
    RfError error = { 0 };
    if ( load( text, &camera, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return camera;
}

void expect_path_fault( const char* text, const char* part )
{
    RfCamera camera;
    RfError error = { 0 };
    RfResult result = load( text, &camera, &error );
    rf_destroy_camera( &camera );
    if ( result == RF_OK || strstr( error.text, part ) == NULL || strchr( error.text, '\n' ) != NULL ||
         strstr( error.text, "/path.json: " ) == NULL )
        fail_msg( "'%s' gave '%s' instead of '%s'", text, result == RF_OK ? "no error" : error.text, part );
    RfResult again = load( text, &camera, NULL ); // the report may be NULL
    assert_int_equal( again, result );
}

RfView view_at( const RfCamera* camera, double time )
{
    RfView view;
    RfError error = { 0 };
    if ( rf_sample_camera_track( camera->track, time, &view, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return view;
}

void assert_close( double got, double want, double tolerance )
{
    if ( !( fabs( got - want ) <= tolerance ) )
        fail_msg( "got %.17g, wanted %.17g to within %g", got, want, tolerance );
}

void assert_three( const double got[3], double x, double y, double z, double tolerance )
{
    assert_close( got[0], x, tolerance );
    assert_close( got[1], y, tolerance );
    assert_close( got[2], z, tolerance );
}

// ---- convert support ----

int convert_enter( void** state )
{
    (void)state;
    cli_enter();
    return 0;
}

int convert_leave( void** state )
{
    (void)state;
    cli_leave();
    return 0;
}

void convert_write( const char* name, const char* text ) { cli_write( name, text, strlen( text ) ); }

bool convert_near( double a, double b ) { return fabs( a - b ) <= 1e-5 * ( 1.0 + fabs( b ) ); }

void convert_assert_point( const float* p, double x, double y, double z )
{
    if ( !convert_near( p[0], x ) || !convert_near( p[1], y ) || !convert_near( p[2], z ) )
        fail_msg( "wanted %g %g %g, got %g %g %g", x, y, z, (double)p[0], (double)p[1], (double)p[2] );
}

RfScene convert_load( const char* name )
{
    RfScene scene;
    RfLog log = { 0 };
    RfError error;
    if ( rf_load_gltf( cli_path( name ), &scene, &log, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return scene;
}

// Nothing but what the test wrote and the two files of cli_run.
void convert_assert_files( int count )
{
    int found = cli_count_files( "", "." );
    if ( found != count + 2 )
        fail_msg( "%d files instead of %d", found - 2, count );
}

static const char s_obj[] = "mtllib a.mtl\no floor\nv 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n"
                            "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.75\nvn 0 0 1\n"
                            "usemtl wall\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
                            "usemtl lamp\nf 1 2 3\nusemtl glass\nf 1 2 3\nusemtl gold\nf 1 2 3\nl 1 2\n";
static const char s_mtl[] = "newmtl wall\nKd 0.5 0.25 0.125\nKs 0.5 0.5 0.5\nNs 30\nmap_Kd wall.png\n"
                            "newmtl lamp\nKd 0 0 0\nKe 12 6 3\n"
                            "newmtl glass\nKd 0 0 0\nKs 1 1 1\nTf 1 0.9 0.8\nNi 1.33\nillum 7\n"
                            "newmtl gold\nKd 0 0 0\nKs 0.9 0.7 0.25\nNs 30\n";

void convert_write_obj( void )
{
    static const uint8_t pixels[6] = { 255, 0, 0, 0, 0, 255 };
    size_t size;
    uint8_t* png = encode_png( 2, 1, 3, pixels, &size );
    cli_write( "wall.png", png, size );
    free( png );
    convert_write( "a.obj", s_obj );
    convert_write( "a.mtl", s_mtl );
}
