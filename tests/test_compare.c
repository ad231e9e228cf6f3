// `compare` as a script sees it: exit status, JSON, and what it refuses.
#include "cli/commands.h"
#include "image/sequence.h"
#include "test_image_support.h"

#include <jansson.h>
#include <math.h>

static void write_constant( const char* name, int side, float value )
{
    RfImage image;
    RfError error;
    assert_int_equal( rf_create_image( side, side, &image, &error ), RF_OK );
    for ( int i = 0; i < 3 * side * side; ++i )
        image.rgb[i] = value;
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    assert_int_equal( rf_write_exr( temp_path( name ), &image, &options, &error ), RF_OK );
    rf_destroy_image( &image );
}

// Runs compare; `option` may be NULL.
static int compare( const char* a, const char* b, const char* option, const char* value )
{
    char* arguments[8] = { "compare", (char*)temp_path( a ), (char*)temp_path( b ), "--json",
                           (char*)temp_path( "out.json" ), (char*)option, (char*)value, NULL };
    remove( arguments[4] );
    return rf_command_compare( option == NULL ? 5 : value == NULL ? 6 : 7, arguments );
}

static json_t* load_json( void )
{
    json_t* json = json_load_file( temp_path( "out.json" ), 0, NULL );
    assert_non_null( json );
    return json;
}

static double number( const json_t* json, const char* key )
{
    const json_t* value = json_object_get( json, key );
    assert_true( json_is_number( value ) );
    return json_number_value( value );
}

static void test_files( void** state )
{
    (void)state;
    write_constant( "a.exr", 40, 0.75f );
    write_constant( "b.exr", 40, 0.5f );
    assert_int_equal( compare( "a.exr", "b.exr", "--diff", temp_path( "d.exr" ) ), 0 );
    json_t* json = load_json();
    assert_true( fabs( number( json, "relmse" ) - 0.1875 / 0.251 ) < 1e-8 );
    assert_true( fabs( number( json, "relmse_trimmed" ) - 0.1875 / 0.251 ) < 1e-8 );
    assert_true( number( json, "mse" ) == 0.0625 && number( json, "bias" ) == 0.25 && number( json, "max" ) == 0.25 );
    assert_true( number( json, "bias_low" ) <= 0.25 && number( json, "bias_high" ) >= 0.25 );
    assert_true( number( json, "nan" ) == 0.0 && number( json, "inf" ) == 0.0 );
    const json_t* frames = json_object_get( json, "frames" );
    assert_int_equal( json_array_size( frames ), 1 );
    assert_true( number( json_array_get( frames, 0 ), "frame" ) == 1.0 );
    json_decref( json );
    RfImage diff;
    assert_int_equal( rf_read_exr( temp_path( "d.exr" ), &diff, NULL ), RF_OK );
    assert_true( diff.rgb[0] == 0.25f && diff.rgb[3 * 1600 - 1] == 0.25f );
    rf_destroy_image( &diff );
}

static void test_sequences( void** state )
{
    (void)state;
    for ( int frame = 3; frame <= 5; ++frame )
    {
        char name[64];
        assert_int_equal( rf_sequence_name( "s.####.exr", frame, name, sizeof name, NULL ), RF_OK );
        write_constant( name, 20, (float)frame );
        assert_int_equal( rf_sequence_name( "t.####.exr", frame, name, sizeof name, NULL ), RF_OK );
        write_constant( name, 20, 3.0f );
    }
    assert_int_equal( compare( "s.####.exr", "t.####.exr", "--diff", temp_path( "d.##.exr" ) ), 0 );
    json_t* json = load_json();
    const json_t* frames = json_object_get( json, "frames" );
    assert_int_equal( json_array_size( frames ), 3 );
    assert_true( number( json_array_get( frames, 2 ), "frame" ) == 5.0 );
    assert_true( number( json_array_get( frames, 2 ), "mse" ) == 4.0 );
    assert_true( number( json, "bias" ) == 1.0 && number( json, "max" ) == 2.0 );
    assert_true( fabs( number( json, "mse" ) - 5.0 / 3.0 ) < 1e-8 );
    json_decref( json );
    assert_int_equal( access( temp_path( "d.05.exr" ), F_OK ), 0 );
    assert_int_equal( compare( "s.####.exr", "t.####.exr", "--diff", temp_path( "one.exr" ) ), 2 );
    assert_int_equal( compare( "s.####.exr", "b.exr", NULL, NULL ), 2 );
    assert_int_equal( remove( temp_path( "t.0004.exr" ) ), 0 );
    assert_int_equal( compare( "s.####.exr", "t.####.exr", NULL, NULL ), 1 );
    assert_int_not_equal( access( temp_path( "out.json" ), F_OK ), 0 );
}

static void test_not_finite( void** state )
{
    (void)state;
    write_constant( "nan.exr", 40, NAN );
    assert_int_equal( compare( "nan.exr", "b.exr", "--quiet", NULL ), 1 );
    json_t* json = load_json();
    assert_true( json_is_null( json_object_get( json, "relmse" ) ) );
    assert_true( number( json, "nan" ) == 1600.0 );
    json_decref( json );
    // of the reference they are counted too, over all frames
    assert_int_equal( compare( "b.exr", "nan.exr", NULL, NULL ), 1 );
    json = load_json();
    assert_true( number( json, "nan" ) == 0.0 && number( json, "reference_nan" ) == 1600.0 );
    assert_true( json_is_null( json_object_get( json, "mse" ) ) );
    json_decref( json );
    write_constant( "inf.exr", 40, INFINITY );
    assert_int_equal( compare( "inf.exr", "inf.exr", NULL, NULL ), 1 );
    json = load_json();
    assert_true( number( json, "inf" ) == 1600.0 && number( json, "reference_inf" ) == 1600.0 && number( json, "reference_nan" ) == 0.0 );
    json_decref( json );
}

static void test_refused( void** state )
{
    (void)state;
    write_constant( "small.exr", 39, 1.0f );
    assert_int_equal( compare( "small.exr", "b.exr", NULL, NULL ), 1 );
    assert_int_equal( compare( "none.exr", "b.exr", NULL, NULL ), 1 );
    assert_int_equal( compare( "a.exr", "b.exr", "--what", NULL ), 2 );
    char* one[] = { "compare", "a.exr", NULL };
    assert_int_equal( rf_command_compare( 2, one ), 2 );
    char* help[] = { "compare", "--help", NULL };
    assert_int_equal( rf_command_compare( 2, help ), 0 );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_files ),
        cmocka_unit_test( test_sequences ),
        cmocka_unit_test( test_not_finite ),
        cmocka_unit_test( test_refused ),
    };
    return cmocka_run_group_tests_name( "compare", tests, make_temp_folder, remove_temp_folder );
}
