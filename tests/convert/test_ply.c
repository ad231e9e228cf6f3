// The PLY reader: the three encodings, polygons, colours, what is ignored, and every error
// line.
#include "convert/model.h"
#include "support/scene_files.h"
#include "support/test.h"

static GltfFolder s_folder;
static int s_warnings;
static char s_warning[512];

static void keep_warning( void* user, const char* line )
{
    (void)user;
    ++s_warnings;
    snprintf( s_warning, sizeof s_warning, "%s", line );
}

static RfResult load( const void* bytes, size_t size, RfModel* model, RfError* error )
{
    RfLog log = { .fn = keep_warning };
    s_warnings = 0;
    return rf_read_ply( write_bytes( &s_folder, "a.bin", bytes, size ), model, &log, error );
}

static RfModelMesh* load_ok( const void* bytes, size_t size, RfModel* model )
{
    RfError error;
    if ( load( bytes, size, model, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return model->meshes;
}

static void assert_fails( const char* text, const char* words )
{
    RfModel model;
    RfError error;
    assert_int_not_equal( load( text, strlen( text ), &model, &error ), RF_OK );
    if ( strstr( error.text, words ) == NULL )
        fail_msg( "'%s' does not say '%s'", error.text, words );
    assert_int_equal( model.mesh_count, 0 );
}

#define VERTICES "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
#define FACES( n ) "element face " #n "\nproperty list uchar int vertex_indices\n"
#define SQUARE "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"

TEST( test_ascii_is_read )
{
    static const char text[] =
        "ply\r\nformat ascii 1.0\r\ncomment any words at all here, more than six of them\n" VERTICES
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float u\nproperty float v\n"
        "element stray 2\nproperty list uchar float things\nproperty int other\n" FACES(
            2 ) "end_header\n"
                "0 0 0 255 0 128 0 0\n1e0 0 -0 255 0 128 1 0\n 1.00 1 0 255 0 128 1 1\n+0 .1e1 0 255 0 128 0 0.25\n"
                "2 1.5 2.5 7\n0 8\n4 0 1 2 3\n3 0\t1 2";
    AUTO_BY( rf_destroy_model ) RfModel model;
    RfModelMesh* m = load_ok( text, sizeof text - 1, &model );
    assert_true( m->vertex_count == 4 && m->triangle_count == 3 && m->normals == NULL );
    static const float positions[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
    static const uint32_t indices[] = { 0, 1, 2, 0, 2, 3, 0, 1, 2 };
    assert_memory_equal( m->indices, indices, sizeof indices );
    for ( int i = 0; i < 12; ++i )
        assert_true( m->positions[i] == positions[i] );
    assert_true( m->uvs[7] == 0.75f && m->uvs[0] == 0.0f && m->uvs[1] == 1.0f ); // v runs down
    assert_true( m->colors[0] == 1.0f && m->colors[1] == 0.0f && fabsf( m->colors[2] - 0.2158605f ) < 1e-5f &&
                 m->colors[3] == 1.0f );
    assert_int_equal( s_warnings, 0 );
}

// The square with normals, bytes in either order.
static size_t binary_square( bool big, uint8_t* out )
{
    char head[512];
    int length = snprintf( head, sizeof head,
                           "ply\nformat binary_%s_endian 1.0\n%sproperty double nx\nproperty short ny\nproperty int8 nz\n"
                           "element face 1\nproperty uchar skipped\nproperty list ushort uint vertex_index\nend_header\n",
                           big ? "big" : "little", VERTICES );
    memcpy( out, head, (size_t)length );
    size_t at = (size_t)length;
    static const float positions[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
#define PUT( value )                                                                                                             \
    do                                                                                                                           \
    {                                                                                                                            \
        const uint8_t* raw = (const uint8_t*)&( value );                                                                         \
        for ( size_t k = 0; k < sizeof( value ); ++k )                                                                           \
            out[at++] = raw[big ? sizeof( value ) - 1 - k : k];                                                                  \
    } while ( 0 )
    double zero = 0.0;
    int16_t y = 0;
    int8_t z = 2;
    for ( int i = 0; i < 4; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            PUT( positions[3 * i + c] );
        PUT( zero );
        PUT( y );
        PUT( z );
    }
    uint8_t skipped = 9;
    uint16_t count = 4;
    PUT( skipped );
    PUT( count );
    for ( uint32_t i = 0; i < 4; ++i )
        PUT( i );
    return at;
}

TEST( test_both_byte_orders_are_read )
{
    for ( int big = 0; big < 2; ++big )
    {
        uint8_t bytes[1024];
        size_t size = binary_square( big != 0, bytes );
        RfModel model;
        RfModelMesh* m = load_ok( bytes, size, &model );
        assert_true( m->vertex_count == 4 && m->triangle_count == 2 && m->positions[6] == 1.0f && m->positions[10] == 1.0f );
        for ( int i = 0; i < 4; ++i )
            assert_true( m->normals[3 * i] == 0.0f && m->normals[3 * i + 2] == 1.0f ); // made unit
        rf_destroy_model( &model );
        RfError error;
        for ( size_t cut = 1; cut < size; ++cut ) // truncated anywhere
        {
            assert_int_not_equal( load( bytes, size - cut, &model, &error ), RF_OK );
            assert_int_equal( model.mesh_count, 0 );
        }
    }
}

static double area_of( const RfModelMesh* m )
{
    double sum = 0.0;
    for ( uint32_t i = 0; i < m->triangle_count; ++i )
    {
        const uint32_t* t = m->indices + 3 * (size_t)i;
        const float *a = m->positions + 3 * (size_t)t[0], *b = m->positions + 3 * (size_t)t[1],
                    *c = m->positions + 3 * (size_t)t[2];
        double area =
            0.5 * ( (double)( b[0] - a[0] ) * (double)( c[1] - a[1] ) - (double)( c[0] - a[0] ) * (double)( b[1] - a[1] ) );
        assert_true( area > 0.0 ); // all of the polygon's sense
        sum += area;
    }
    return sum;
}

TEST( test_concave_polygons_are_cut )
{
    // an arrow head and an L of six corners, as polygons
    static const char text[] = "ply\nformat ascii 1.0\nelement vertex 10\nproperty float x\nproperty float y\nproperty float z\n"
                               "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                               "0 0 0 2 1 0 0 2 0 0.5 1 0\n0 0 5 3 0 5 3 1 5 1 1 5 1 3 5 0 3 5\n4 0 1 2 3\n6 4 5 6 7 8 9\n";
    AUTO_BY( rf_destroy_model ) RfModel model;
    RfModelMesh* m = load_ok( text, sizeof text - 1, &model );
    assert_int_equal( m->triangle_count, 6 );
    assert_true( fabs( area_of( m ) - ( 1.5 + 5.0 ) ) < 1e-6 );
}

#define HEAD "ply\nformat ascii 1.0\n"

TEST( test_warnings_say_what_is_left_out )
{
    static const char text[] = HEAD VERTICES "property float nx\nproperty float ny\nproperty float nz\n" FACES(
        2 ) "end_header\n0 0 0 0 0 1 1 0 0 0 0 1 1 1 0 0 0 0 0 1 0 0 0 1\n2 0 1 3 0 1 2";
    AUTO_BY( rf_destroy_model ) RfModel model;
    RfModelMesh* m = load_ok( text, sizeof text - 1, &model );
    assert_true( m->normals == NULL && m->triangle_count == 1 && s_warnings == 2 );
    assert_non_null( strstr( s_warning, "less than three corners" ) );
}

#define STRIPS "element tristrips 1\nproperty list int int vertex_indices\n"

// As Stanford has them: every second triangle turned round, -1 starts anew, and
// triangles without area turn corners.
TEST( test_strips_as_stanford_has_them )
{
    static const char text[] = HEAD "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n" STRIPS
                                    "end_header\n0 0 0 1 0 0 0 1 0 1 1 0 0 2 0 1 2 0\n13 0 1 2 3 4 -1 3 3 4 5 -1 -1 1\n\n";
    static const uint32_t indices[] = { 0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5 };
    AUTO_BY( rf_destroy_model ) RfModel model;
    RfModelMesh* m = load_ok( text, sizeof text - 1, &model );
    assert_int_equal( m->triangle_count, 4 );
    assert_memory_equal( m->indices, indices, sizeof indices );
    assert_true( s_warnings == 1 && strstr( s_warning, "1 faces" ) != NULL ); // the lone corner
    assert_true( fabs( area_of( m ) - 2.0 ) < 1e-6 );
    assert_fails( HEAD VERTICES STRIPS "end_header\n" SQUARE "4 0 1 2 4\n",
                  "line 14: corner 3 of tristrips 0 is vertex 4 of 4, and not -1" );
    assert_fails( HEAD VERTICES STRIPS "end_header\n" SQUARE "4 0 1 2 -2\n", "vertex -2 of 4" );
    assert_fails( HEAD VERTICES STRIPS "end_header\n" SQUARE "4 0 1 2\n", "ends too early" );
    assert_fails( HEAD VERTICES STRIPS "end_header\n" SQUARE "4 0 1 -1 2\n", "has no faces" );
    assert_fails( HEAD STRIPS VERTICES "end_header\n3 0 1 2\n" SQUARE, "tristrips come before" );
    assert_fails( HEAD VERTICES "element tristrips 1\nproperty int material\nend_header\n" SQUARE "7\n",
                  "element tristrips has no list vertex_indices" );
}

TEST( test_trailing_bytes_are_faults )
{
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "3 0 1 2\n3 1 2 3\n",
                  "line 15: 8 bytes follow the last element" );
    uint8_t bytes[1024];
    size_t size = binary_square( false, bytes );
    bytes[size] = '\n';
    RfModel model;
    RfError error;
    assert_int_equal( load( bytes, size + 1, &model, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "1 bytes follow the last element" ) );
}

TEST( test_faults_are_one_line )
{
    assert_fails( "plx\n", "line 1: does not begin with 'ply'" );
    assert_fails( "ply\nformat ascii 1.0\n", "line 3: the header has no end_header" );
    assert_fails( "ply\nformat ascii 2.0\n", "line 2: format must be" );
    assert_fails( "ply\nend_header\n", "no format" );
    assert_fails( HEAD HEAD, "line 3: 'ply' is not a keyword" );
    assert_fails( HEAD "format ascii 1.0\n", "line 3: a second format" );
    assert_fails( HEAD "elephant 3\n", "line 3: 'elephant' is not a keyword" );
    assert_fails( HEAD "element vertex\n", "a name and a count" );
    assert_fails( HEAD "element vertex -1\n", "not an integer" );
    assert_fails( HEAD "property float x\n", "before any element" );
    assert_fails( HEAD "element vertex 1\nproperty quad x\n", "type of property x is unknown" );
    assert_fails( HEAD "element vertex 1\nproperty list float int x\n", "must have an integer type" );
    assert_fails( HEAD "element vertex 1\nproperty float\n", "property must have a type" );
    assert_fails( HEAD "element vertex 2147483648\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n",
                  "need more than" );
    assert_fails( HEAD "element vertex 999999999999999999\nproperty float x\nend_header\n", "need more than" );
    assert_fails( HEAD "element vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n", "no x, y and z" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE, "ends too early" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "3 0 1\n", "ends too early" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "200 0 1\n", "list vertex_indices has a length of 200" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "3 0 1 4\n", "line 14: corner 2 of face 0 is vertex 4 of 4" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "3 0 1 9999999999\n", "'9999999999' does not fit into int" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "259 0 1 2\n", "'259' does not fit into uchar" );
    assert_fails( HEAD VERTICES "property int red\nproperty int green\nproperty int blue\n" FACES(
                      1 ) "end_header\n0 0 0 9 9 9 1 0 0 9 9 9 1 1 0 9 9 9 0 1 0 9 9 9 3 0 1 2\n",
                  "property red must be uchar, ushort or float" );
    static const char zero[] = HEAD VERTICES FACES( 1 ) "end_header\n0\0junk 0 0 1 0 0 1 1 0 0 1 0 3 0 1 2\n";
    RfModel none;
    RfError line;
    assert_int_not_equal( load( zero, sizeof zero - 1, &none, &line ), RF_OK );
    assert_non_null( strstr( line.text, "a zero byte in text" ) );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "3 0 1 -1\n", "corner 2 of face 0" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "3 0 1 1.5\n", "'1.5' is not an integer" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n" SQUARE "-3 0 1 2\n", "'-3' does not fit into uchar" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n0 0 0 1 zero 0 1 1 0 0 1 0 3 0 1 2\n", "'zero' is not a number" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n0 0 0 1 1e60 0 1 1 0 0 1 0 3 0 1 2\n",
                  "y of vertex 1 is not a finite number" );
    assert_fails( HEAD VERTICES FACES( 1 ) "end_header\n0 0 0 1 nan 0 1 1 0 0 1 0 3 0 1 2\n", "'nan' is not a number" );
    assert_fails( HEAD FACES( 1 ) VERTICES "end_header\n3 0 1 2\n" SQUARE, "faces come before" );
    assert_fails( HEAD VERTICES "element face 1\nproperty int material\nend_header\n" SQUARE "7\n", "no list vertex_indices" );
    assert_fails( HEAD VERTICES "end_header\n" SQUARE, "has no faces" );
    RfModel model;
    RfError error;
    assert_int_equal( rf_read_ply( "/nowhere/at/all.ply", &model, NULL, &error ), RF_ERROR_IO );
    assert_int_equal( rf_read_ply( "/dev/zero", &model, NULL, &error ), RF_ERROR_IO );
}

// A comment may be of any length; colours stay between 0 and 1; what has no
// material is no metal.
TEST( test_what_is_taken_leniently )
{
    char text[2048], words[1001];
    memset( words, 'a', 1000 );
    words[1000] = 0;
    snprintf( text, sizeof text,
              HEAD "comment %s\n" VERTICES "property float red\nproperty float green\nproperty float blue\n" FACES(
                  1 ) "end_header\n0 0 0 -2 9 .5 1 0 0 1 1 1 1 1 0 1 1 1 0 1 0 1 1 1 3 0 1 2\n",
              words );
    AUTO_BY( rf_destroy_model ) RfModel model;
    RfModelMesh* m = load_ok( text, strlen( text ), &model );
    assert_true( m->colors[0] == 0.0f && m->colors[1] == 1.0f && m->colors[2] == 0.5f && s_warnings == 1 );
    assert_non_null( strstr( s_warning, "2 colour values" ) );
    assert_true( m->material == 0 && model.material_count == 1 && model.materials->metallic == 0.0f );
}

enum
{
    CORNERS = 40000,
    FACES_MADE = 20,
    ROOM = 16 * CORNERS * ( FACES_MADE + 1 )
};

// Faces with many corners around a point: one after another, or each `stride` further on than the one before.
static RfResult load_large_faces( int64_t stride, RfModel* model, RfError* error )
{
    AUTO_FREE uint8_t* bytes = malloc( ROOM );
    size_t at = (size_t)snprintf(
        (char*)bytes, ROOM,
        "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\n"
        "property float y\nproperty float z\nelement face %d\nproperty list int int vertex_indices\nend_header\n",
        CORNERS, FACES_MADE );
    for ( int64_t i = 0; i < CORNERS; ++i )
    {
        double turn = 2.0 * 3.14159265358979 * (double)( i * stride % CORNERS ) / CORNERS, radius = i % 2 == 0 ? 0.5 : 1.0;
        float p[3] = { (float)( radius * cos( turn ) ), (float)( radius * sin( turn ) ), 0.0f };
        memcpy( bytes + at, p, sizeof p );
        at += sizeof p;
    }
    for ( int f = 0; f < FACES_MADE; ++f )
    {
        int32_t n = CORNERS;
        memcpy( bytes + at, &n, 4 );
        at += 4;
        for ( int32_t i = 0; i < n; ++i, at += 4 )
            memcpy( bytes + at, &i, 4 );
    }
    return load( bytes, at, model, error );
}

static double area_of_model( const RfModel* model )
{
    const RfModelMesh* m = model->meshes;
    double sum = 0.0;
    for ( uint32_t i = 0; i < m->triangle_count; ++i )
    {
        const float *a = m->positions + 3 * (size_t)m->indices[3 * i], *b = m->positions + 3 * (size_t)m->indices[3 * i + 1],
                    *c = m->positions + 3 * (size_t)m->indices[3 * i + 2];
        sum += 0.5 * fabs( ( (double)b[0] - (double)a[0] ) * ( (double)c[1] - (double)a[1] ) -
                           ( (double)c[0] - (double)a[0] ) * ( (double)b[1] - (double)a[1] ) );
    }
    return sum;
}

// Teeth all around are cut in no time; what is tangled must not take for ever.
TEST( test_large_polygons_take_bounded_time )
{
    RfModel model;
    RfError error;
    assert_int_equal( load_large_faces( 1, &model, &error ), RF_OK );
    assert_int_equal( model.meshes->triangle_count, FACES_MADE * ( CORNERS - 2 ) );
    double teeth = FACES_MADE * CORNERS * 0.5 * 0.5 * sin( 2.0 * 3.14159265358979 / CORNERS );
    assert_true( fabs( area_of_model( &model ) / teeth - 1.0 ) < 1e-4 );
    rf_destroy_model( &model );
    assert_int_equal( load_large_faces( 3, &model, &error ), RF_ERROR_UNSUPPORTED );
    assert_non_null( strstr( error.text, "of 40000 corners takes too long to triangulate: triangulate it first" ) );
}

// A square with a square hole, which an edge that runs there and back joins to the border, both ends twice in the file.
TEST( test_polygon_with_a_hole )
{
    static const char text[] = "ply\nformat ascii 1.0\nelement vertex 10\nproperty float x\nproperty float y\nproperty float z\n"
                               "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                               "0 0 0\n4 0 0\n4 4 0\n0 4 0\n0 0 0\n1 1 0\n1 3 0\n3 3 0\n3 1 0\n1 1 0\n"
                               "10 0 1 2 3 4 5 6 7 8 9\n";
    RfModel model;
    s_warnings = 0;
    load_ok( text, strlen( text ), &model );
    assert_int_equal( model.meshes->triangle_count, 8 );
    assert_true( fabs( area_of_model( &model ) - 12.0 ) < 1e-6 && s_warnings == 0 );
    rf_destroy_model( &model );
}

// Whatever becomes of the bytes: a result or an error line, in no time.
TEST( test_mutations_never_crash )
{
    for ( uint64_t number = 0; number < 4000; ++number )
    {
        uint8_t bytes[1024];
        size_t size = binary_square( number % 2 == 0, bytes );
        size_t head = size - 124;
        if ( number % 3 == 0 )
            size = mutate_bytes( bytes, size, number );
        else
            bytes[head + number * 7919 % ( size - head )] = (uint8_t)( number * 31 );
        RfModel model;
        RfError error;
        if ( load( bytes, size, &model, &error ) == RF_OK )
            rf_destroy_model( &model );
        else
            assert_true( strlen( error.text ) > 10 && strchr( error.text, '\n' ) == NULL );
    }
}

static int enter( void** state )
{
    (void)state;
    s_folder = make_folder();
    return 0;
}

static int leave( void** state )
{
    (void)state;
    remove_folder( &s_folder );
    return 0;
}

SHARED_BY_TESTS( enter, leave )
