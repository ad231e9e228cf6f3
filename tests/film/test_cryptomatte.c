// Cryptomatte: the hash against published vectors, ids that are proper floats, tables of pixels, ranks, and the manifest as JSON.
#include "support/test.h"
#include "film/cryptomatte.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static float as_float( uint32_t bits )
{
    float value;
    memcpy( &value, &bits, sizeof value );
    return value;
}

// Of MurmurHash3_x86_32 with seed 0, as Wikipedia's "MurmurHash" lists them; and of the specification's examples, which are ids.
TEST( test_hash_of_published_texts )
{
    assert_int_equal( rf_murmur3_32( "" ), 0 );
    assert_int_equal( rf_murmur3_32( "test" ), 0xba6bd213 );
    assert_int_equal( rf_murmur3_32( "Hello, world!" ), 0xc0363e43 );
    assert_int_equal( rf_murmur3_32( "The quick brown fox jumps over the lazy dog" ), 0x2e4ff723 );
    assert_int_equal( rf_cryptomatte_id( "bunny" ), 0x13851a76 );
    assert_int_equal( rf_cryptomatte_id( "default" ), 0x42c9679f );
    assert_int_equal( rf_cryptomatte_id( "bunny_porcelain_mat" ), 0xb24b26d4 );
}

TEST( test_ids_are_normal_floats )
{
    int low = 0, high = 0;
    for ( int i = 0; i < 20000; ++i )
    {
        char name[16];
        snprintf( name, sizeof name, "object %d", i );
        uint32_t hash = rf_murmur3_32( name ), exponent = hash >> 23 & 255u, id = rf_cryptomatte_id( name );
        assert_true( isnormal( as_float( id ) ) );
        low += exponent == 0;
        high += exponent == 255;
        if ( exponent != 0 && exponent != 255 )
            assert_int_equal( id, hash );
        else
            assert_int_equal( id ^ hash, 1u << 23 );
    }
    assert_true( low > 40 && high > 40 );
}

TEST( test_kinds_and_their_names )
{
    unsigned kinds = 99;
    RfError error = { 0 };
    char text[RF_CRYPTOMATTE_TEXT_SIZE];
    assert_int_equal( rf_parse_cryptomatte( NULL, &kinds, &error ), RF_OK );
    assert_int_equal( kinds, 0 );
    assert_int_equal( rf_parse_cryptomatte( "asset,object,material", &kinds, &error ), RF_OK );
    rf_format_cryptomatte( kinds, text );
    assert_string_equal( text, "object,material,asset" );
    assert_int_equal( rf_parse_cryptomatte( "asset", &kinds, &error ), RF_OK );
    assert_int_equal( kinds, RF_CRYPTOMATTE_ASSET );
    static const char* const s_wrong[][2] = { { "objekt", "unknown Cryptomatte 'objekt', did you mean object?" },
                                              { "", "expected object, material or asset" },
                                              { "object,", "expected object, material or asset" },
                                              { "asset,asset", "Cryptomatte of kind asset is given twice" } };
    for ( size_t i = 0; i < sizeof s_wrong / sizeof s_wrong[0]; ++i )
    {
        assert_int_equal( rf_parse_cryptomatte( s_wrong[i][0], &kinds, &error ), RF_ERROR_USAGE );
        assert_non_null( strstr( error.text, s_wrong[i][1] ) );
    }
}

// Whatever the order, no surface has more than was added, what is lost is accounted for, and those of much weight stay.
TEST( test_tables_that_are_full )
{
    for ( int order = 0; order < 3; ++order )
    {
        RfCovering p = { 0 };
        double added[64] = { 0 }, all = 0.0, kept = 0.0;
        for ( uint32_t i = 0; i < 6000; ++i )
        {
            uint32_t n = order == 0 ? i : order == 1 ? 5999 - i : i * 2477u % 6000, surface = n % 4 < 2 ? 1 + n % 4 : 3 + n % 29;
            float weight = 0.25f + (float)( n % 5 );
            rf_add_covering( &p, surface, weight );
            added[surface] += (double)weight;
            all += (double)weight;
        }
        rf_add_covering( &p, 0, 7.0f );
        for ( int k = 0; k < RF_COVERING_MOST; ++k )
        {
            assert_true( p.surface[k] != 0 && (double)p.weight[k] <= added[p.surface[k]] * ( 1.0 + 1e-5 ) );
            if ( p.surface[k] < 3 )
                assert_true( fabs( (double)p.weight[k] / added[p.surface[k]] - 1.0 ) < 1e-5 );
            kept += (double)p.weight[k];
            for ( int other = 0; other < k; ++other )
                assert_true( p.surface[other] != p.surface[k] );
        }
        assert_true( fabs( kept + (double)p.lost - all ) < 1e-3 * all );
        assert_true( p.nothing == 7.0f && p.lost > 0.0f );
    }
}

// A scene of names alone: nodes 0 to 2, of which the last two are below the first and of one name, and two materials.
static char s_root[] = "Root", s_twin[] = "Twin", s_odd[] = "a \"b\" \\ \x01 \xc3\xa4", s_plain[] = "plain";
static RfNode s_nodes[] = { { .name = s_root, .parent = -1 }, { .name = s_twin, .parent = 0 }, { .name = s_twin, .parent = 0 } };
static RfMaterial s_materials[] = { { .name = s_odd, .pass_index = 0 }, { .name = s_plain, .pass_index = 5 } };
static RfNodeRun s_runs[] = { { 0, 2 }, { 1, 3 } };

static RfScene names_alone( void )
{
    return ( RfScene ){ .nodes = s_nodes,
                        .node_count = 3,
                        .materials = s_materials,
                        .material_count = 2,
                        .node_runs = s_runs,
                        .node_run_count = 2,
                        .triangles.count = 2 };
}

static uint32_t pair( uint32_t node, uint32_t material ) { return 1 + ( node + 1 ) * 2 + material; }

TEST( test_ranks )
{
    RfScene scene = names_alone();
    RfCovering p = { .nothing = 1.0f, .lost = 1.0f };
    float ranks[3][4], *layers[3] = { ranks[0], ranks[1], ranks[2] };
    rf_add_covering( &p, pair( 0, 1 ), 3.0f );
    rf_add_covering( &p, pair( 1, 0 ), 2.0f );
    rf_add_covering( &p, pair( 2, 1 ), 2.0f );
    rf_add_covering( &p, pair( 2, 0 ), 1.0f );
    static const struct
    {
        int kind;
        const char* name[2];
        double coverage[2];
    } s_cases[] = { { 0, { "Twin", "Root" }, { 0.5, 0.3 } },
                    { 1, { "plain", s_odd }, { 0.5, 0.3 } },
                    { 2, { "Root" }, { 0.8 } } };
    for ( int c = 0; c < 3; ++c )
    {
        RfCryptomatteIds ids;
        assert_int_equal( rf_make_cryptomatte_ids( &scene, s_cases[c].kind, &ids, NULL ), RF_OK );
        rf_finish_cryptomatte( &p, 1, &ids, layers );
        for ( int k = 0; k < 6; ++k )
        {
            const char* name = k < 2 ? s_cases[c].name[k] : NULL;
            float id = ranks[k / 2][2 * ( k % 2 )], coverage = ranks[k / 2][2 * ( k % 2 ) + 1];
            float wanted = name != NULL ? as_float( rf_cryptomatte_id( name ) ) : 0.0f;
            assert_memory_equal( &id, &wanted, sizeof id );
            assert_true( fabs( (double)coverage - ( k < 2 ? s_cases[c].coverage[k] : 0.0 ) ) < 1e-6 );
        }
        rf_destroy_cryptomatte_ids( &ids );
    }
    float image = -1.0f, of_node[] = { 0, 7, 8, 9 };
    rf_finish_index( &p, 1, &scene, RF_AOV_OBJECT_INDEX, of_node, &image );
    assert_true( image ==
                 7.0f ); // Twin are two objects, of indices 8 and 9: 2 and 3 of 10, of which the first has been there before
    of_node[3] = 8.0f;
    rf_finish_index( &p, 1, &scene, RF_AOV_OBJECT_INDEX, of_node, &image );
    assert_true( image == 8.0f );
    p.nothing = 6.0f;
    rf_finish_index( &p, 1, &scene, RF_AOV_OBJECT_INDEX, of_node, &image );
    assert_true( image == 0.0f );
}

TEST( test_manifest_is_json )
{
    RfScene scene = names_alone();
    char *objects = rf_cryptomatte_manifest( &scene, 0 ), *materials = rf_cryptomatte_manifest( &scene, 1 ),
         *assets = rf_cryptomatte_manifest( &scene, 2 );
    char wanted[64];
    snprintf( wanted, sizeof wanted, "{\"Twin\":\"%08x\"}", rf_cryptomatte_id( "Twin" ) ); // Root has no surfaces
    assert_string_equal( objects, wanted );
    snprintf( wanted, sizeof wanted, "{\"Root\":\"%08x\"}", rf_cryptomatte_id( "Root" ) );
    assert_string_equal( assets, wanted );
    json_t* json = json_loads( materials, 0, NULL );
    assert_int_equal( json_object_size( json ), 2 );
    snprintf( wanted, sizeof wanted, "%08x", rf_cryptomatte_id( s_odd ) );
    assert_string_equal( json_string_value( json_object_get( json, s_odd ) ), wanted );
    assert_null( strpbrk( materials, "\x01\n" ) );
    json_decref( json );
    free( objects );
    free( materials );
    free( assets );
}
