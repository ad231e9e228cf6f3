// IES files and tables of intensity: what is read, what is refused, where the angles are, and that lamps shine by them.
#include "light/emission.h"
#include "support/rooms.h"
#include "support/test.h"

#define PI 3.14159265358979324
#define HEAD "IESNA:LM-63-2002\r\n[TEST] own\r\nTILT=NONE\r\n"

static RfProfile* read_ok( const char* text )
{
    RfProfile* p = NULL;
    RfError error = { 0 };
    RfResult result = rf_read_ies( "a.ies", text, strlen( text ), &p, &error );
    if ( result != RF_OK )
        fail_msg( "%s", error.text );
    assert_int_equal( p->references, 1 );
    return p;
}

// Vertical and horizontal angle in degrees.
static RfVec3 at( double v, double h )
{
    double s = sin( v * PI / 180.0 );
    return rf_vec3( (float)( -s * sin( h * PI / 180.0 ) ), (float)( -s * cos( h * PI / 180.0 ) ), (float)-cos( v * PI / 180.0 ) );
}

static void assert_value( const RfProfile* p, double v, double h, double want )
{
    double got = (double)rf_profile_value( p, at( v, h ) );
    if ( !( fabs( got - want ) <= 1e-4 * fmax( want, 1.0 ) ) )
        fail_msg( "%g degrees down, %g around: %g instead of %g", v, h, got, want );
}

TEST( test_files_of_all_years_are_read )
{
    // linear between the angles, dark beyond them
    RfProfile* p = read_ok( HEAD "1 1000 2 3 1 1 2 0 0 0\r\n1.5 1 100\r\n0 45 90\r\n0\r\n10 20 0\r\n" );
    assert_value( p, 0, 0, 30 );
    assert_value( p, 22.5, 77, 45 );
    assert_value( p, 67.5, 200, 30 );
    assert_value( p, 91, 0, 0 );
    assert_true( p->most == 60.0f && !p->up && fabs( p->cos_reach ) < 1e-6 );
    rf_release_profile( p );
    // 1986: no first line; a tilt, commas, numbers that go on in the next line
    p = read_ok( "some luminaire\nTILT=INCLUDE\n1\n2\n0,90\n1.0,0.8\n1,1000,1,2,2,1,2,0,0,0,1,1,100\n90\n180 0 180 1,2\n3 4" );
    assert_value( p, 90, 0, 1 );
    assert_value( p, 180, 180, 4 );
    assert_value( p, 135, 90, 2.5 );
    assert_value( p, 45, 0, 0 );
    assert_true( p->up && fabs( p->cos_reach ) < 1e-6 );
    rf_release_profile( p );
}

TEST( test_parts_of_a_turn_are_expanded )
{
    static const struct
    {
        const char* angles;
        int count;
        double want[4]; // at 30, 150, 210, 330 degrees
    } cases[] = {
        { "0 90", 2, { 1.0 + 1.0 / 3.0, 1.0 + 1.0 / 3.0, 1.0 + 1.0 / 3.0, 1.0 + 1.0 / 3.0 } },
        { "0 90 180", 3, { 1.0 + 1.0 / 3.0, 2.0 + 2.0 / 3.0, 2.0 + 2.0 / 3.0, 1.0 + 1.0 / 3.0 } },
        { "90 180 270", 3, { 1.0 + 1.0 / 3.0, 2.0 + 2.0 / 3.0, 2.0 + 2.0 / 3.0, 1.0 + 1.0 / 3.0 } },
        { "0 90 180 360", 4, { 1.0 + 1.0 / 3.0, 2.0 + 2.0 / 3.0, 3.0 + 1.0 / 6.0, 3.0 + 5.0 / 6.0 } },
        { "0 90 180 330", 4, { 1.0 + 1.0 / 3.0, 2.0 + 2.0 / 3.0, 3.2, 4.0 } }, // and the first again
    };
    for ( size_t i = 0; i < sizeof cases / sizeof *cases; ++i )
    {
        char text[256];
        int length =
            snprintf( text, sizeof text, HEAD "1 1000 1 2 %d 1 2 0 0 0 1 1 100\n0 180\n%s\n", cases[i].count, cases[i].angles );
        for ( int k = 1; k <= cases[i].count; ++k )
            length += snprintf( text + length, sizeof text - (size_t)length, "%d %d\n", k, k );
        RfProfile* p = read_ok( text );
        static const double s_turns[] = { 30, 150, 210, 330 };
        for ( int k = 0; k < 4; ++k )
            assert_value( p, 70, s_turns[k], cases[i].want[k] );
        assert_value( p, 70, 0, 1 );
        rf_release_profile( p );
    }
}

TEST( test_faults_are_one_line )
{
    static const char* const cases[][2] = {
        { "", "it is empty" },
        { "[TILT=NONE]\n", "no line begins with TILT=" },
        { "TILT=other.tlt\n", "line 1: TILT names another file: write TILT=NONE" },
        { "TILT=NONE\n1 1000 1 2 1 2 2 0 0 0 1 1 100", "line 2: only photometry of type C" },
        { "TILT=NONE\n1 1000 1 0 1 1", "the number of vertical angles is 0: must be 1 to 4096" },
        { "TILT=NONE\n1 1000 1 2 99999999 1", "the number of horizontal angles is 1e+08" },
        { "TILT=NONE\n1 1000 1 4096 4096 1 2 0 0 0 1 1 100", "more than a million" },
        { "TILT=NONE\n1 1000 1 1 1 1 2 0 0 0 1 1 100 0 0 1", "must be 2 and 1 at least" },
        { "TILT=NONE\n1 1000 nan 2 1 1", "line 2: the multiplier must be a number" },
        { "TILT=NONE\n1 1000 1e999 2 1 1", "the multiplier must be a number" },
        { "TILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 100\n0 90 0 1", "it ends where an intensity is expected" },
        { "TILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 100\n0 90 0 1 -1", "its intensity 1 is -1" },
        { "TILT=NONE\n1 1000 1e20 2 1 1 2 0 0 0 1 1 100\n0 90 0 1 1", "must be 0 to 1e12" },
        { "TILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 100\n0 0 0 1 1", "its vertical angle 1 is 0 degrees" },
        { "TILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 100\n-90 0 0 1 1", "its vertical angle 0 is -90 degrees: must be 0 to 180" },
        { "TILT=NONE\n1 1000 1 2 2 1 2 0 0 0 1 1 100\n0 90 0 100 1 1 1 1", "its horizontal angles are 0 to 100 degrees" },
        { "TILT=NONE\n1 1000 1 2 2 1 2 0 0 0 1 1 100\n0 90 0 359.99999 1 1 1 1", "its horizontal angles are 0 to 360 degrees" },
        { "TILT=NONE\n1 1000 1.00000000000000000000000000000000000000000000000000000000000000001 2 1", "must be a number" },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof *cases; ++i )
    {
        RfProfile* p = NULL;
        RfError error = { 0 };
        RfResult result = rf_read_ies( "a.ies", cases[i][0], strlen( cases[i][0] ), &p, &error );
        if ( result == RF_OK || p != NULL || strstr( error.text, cases[i][1] ) == NULL ||
             strncmp( error.text, "a.ies: ", 7 ) != 0 || strchr( error.text, '\n' ) != NULL )
            fail_msg( "'%s' does not say '%s'", error.text, cases[i][1] );
    }
}

// cos⁴ of the vertical angle, times what is brighter on one side where it is lopsided.
static RfProfile* make_table( bool lopsided )
{
    enum
    {
        ROWS = 181,
        COLUMNS = 25
    };
    static double s_v[ROWS], s_h[COLUMNS], s_value[ROWS * COLUMNS];
    RfProfileTable table = { ROWS, lopsided ? COLUMNS : 1, s_v, s_h, s_value };
    for ( int c = 0; c < table.columns; ++c )
    {
        s_h[c] = 15.0 * c;
        for ( int r = 0; r < ROWS; ++r )
        {
            s_v[r] = 0.5 * r;
            double turn = ( s_h[c] - 40.0 ) * PI / 180.0;
            s_value[c * ROWS + r] =
                pow( fmax( cos( s_v[r] * PI / 180.0 ), 0.0 ), 4.0 ) * ( lopsided ? 1.0 + 0.9 * cos( turn ) : 1.0 );
        }
    }
    RfProfile* p = NULL;
    RfError error = { 0 };
    assert_int_equal( rf_make_profile( "table", &table, &p, &error ), RF_OK );
    return p;
}

static void add_lamp( RfScene* scene, RfProfile* profile )
{
    scene->punctuals = calloc( 1, sizeof *scene->punctuals );
    scene->punctual_count = 1;
    scene->punctuals[0] = make_point_light( rf_vec3( 0, 2, 0 ), 5.0f );
    scene->punctuals[0].turned = true;
    scene->punctuals[0].direction = rf_normalize( rf_vec3( 0.3f, -1.0f, 0.2f ) );
    scene->punctuals[0].across = rf_normalize( rf_cross( scene->punctuals[0].direction, rf_vec3( 0, 0, 1 ) ) );
    scene->punctuals[0].profile = profile;
}

// ∫ cos⁴ over the lower half is 2π / 5; the side that is brighter makes no difference.
TEST( test_emission_follows_the_table )
{
    enum
    {
        STRATA = 500
    };
    for ( int k = 0; k < 2; ++k )
    {
        SceneBuilder b = { 0 };
        uint32_t m = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
        add_quad( &b, m, rf_vec3( -1, 0, 1 ), rf_vec3( 1, 0, 1 ), rf_vec3( 1, 0, -1 ), rf_vec3( -1, 0, -1 ) );
        RfScene scene = finish_scene( &b );
        add_lamp( &scene, make_table( k == 1 ) );
        RfLights lights;
        RfError error;
        assert_int_equal( rf_collect_lights( &scene, &lights, &error ), RF_OK );
        double sum = 0.0;
        for ( int i = 0; i < STRATA * STRATA; ++i )
        {
            double z = 2.0 * ( i % STRATA + 0.5 ) / STRATA - 1.0, turn = 2.0 * PI * ( i / STRATA + 0.5 ) / STRATA,
                   s = sqrt( 1.0 - z * z );
            RfEmission e;
            float u[2] = { 0.5f, 0.5f };
            assert_true( rf_sample_emitter( &lights, &scene, 0, 1.0f, 0.0f, u, &e ) );
            RfVec3 d = rf_vec3( (float)( s * cos( turn ) ), (float)z, (float)( s * sin( turn ) ) );
            if ( rf_emit_towards( &lights, d, &e ) )
                sum += (double)e.radiance.x * 4.0 * PI / ( STRATA * STRATA );
        }
        printf( "flux %.5g of %.5g\n", sum, 5.0 * 2.0 * PI / 5.0 );
        assert_true( fabs( sum / ( 5.0 * 2.0 * PI / 5.0 ) - 1.0 ) < 2e-3 );
        assert_true( fabs( scene.punctuals->profile->mean * 4.0 * PI / ( 2.0 * PI / 5.0 ) - 1.0 ) < 1e-3 );
        rf_destroy_lights( &lights );
        rf_destroy_scene( &scene );
    }
}

TEST( test_towards_is_where_the_table_says )
{
    RfScene scene = { 0 };
    add_lamp( &scene, make_table( true ) );
    // −z of the node down, its x axis along x: −y, horizontal angle 0, is z
    scene.punctuals[0].direction = rf_vec3( 0, -1, 0 );
    scene.punctuals[0].across = rf_vec3( 1, 0, 0 );
    RfVec3 d = rf_normalize( rf_vec3( -0.3f, -1.0f, 0.4f ) ); // 90 degrees is −x
    double h = atan2( 0.3, 0.4 ), v = atan( 0.5 );
    double turn = 15.0 * PI / 180.0, low = floor( h / turn ) * turn, t = ( h - low ) / turn, axis = 40.0 * PI / 180.0;
    double side = 1.0 + 0.9 * ( ( 1.0 - t ) * cos( low - axis ) + t * cos( low + turn - axis ) );
    assert_true( fabs( (double)rf_lamp_falloff( scene.punctuals, d ) / ( pow( cos( v ), 4.0 ) * side ) - 1.0 ) < 1e-3 );
    rf_destroy_scene( &scene );
}
