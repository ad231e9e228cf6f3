// The free memory of nested control groups is that of the tightest one, shown on a made-up
// cgroup folder.
#include "base/system.h"
#include "support/cli_run.h"
#include "support/image_files.h"
#include "support/test.h"

TEST( test_the_tightest_group_above_counts )
{
    const char* root = cli_folder();
    assert_true( rf_cgroup_free_memory( root, "/" ) == SIZE_MAX ); // no such files
    cli_expect( cli_run( "mkdir -p a/b; echo max > a/b/memory.max; echo 700 > a/b/memory.current" ), 0, NULL );
    assert_true( rf_cgroup_free_memory( root, "/a/b" ) == SIZE_MAX ); // no limit
    cli_expect( cli_run( "echo 5000 > a/memory.max; echo 1700 > a/memory.current" ), 0, NULL );
    assert_true( rf_cgroup_free_memory( root, "/a/b" ) == 3300 ); // that of the group above
    cli_expect( cli_run( "printf 'anon 5\nfile 900\ninactive_anon 3\ninactive_file 800\n' > a/memory.stat" ), 0, NULL );
    assert_true( rf_cgroup_free_memory( root, "/a/b" ) == 4100 ); // file pages are had back
    cli_expect( cli_run( "echo 1000 > a/b/memory.max" ), 0, NULL );
    assert_true( rf_cgroup_free_memory( root, "/a/b" ) == 300 && rf_cgroup_free_memory( root, "/a" ) == 4100 );
    cli_expect( cli_run( "echo 2000 > a/b/memory.current" ), 0, NULL );
    assert_true( rf_cgroup_free_memory( root, "/a/b" ) == 0 ); // nothing is left
    assert_true( rf_cgroup_free_memory( root, "/a/none" ) == 4100 );
    assert_true( rf_free_memory() > 0 );
}

TEST( test_groups_of_version_1 )
{
    const char* root = cli_folder();
    cli_expect(
        cli_run( "mkdir -p c/d; echo 9223372036854771712 > c/d/memory.limit_in_bytes; echo 10 > c/d/memory.usage_in_bytes" ), 0,
        NULL );
    cli_expect( cli_run( "echo 6000 > c/memory.limit_in_bytes; echo 1000 > c/memory.usage_in_bytes" ), 0, NULL );
    cli_expect( cli_run( "printf 'cache 5\ntotal_inactive_file 400\n' > c/memory.stat" ), 0, NULL );
    assert_true( rf_cgroup_free_memory( root, "/c/d" ) == 5400 );
    assert_true( rf_cgroup_free_memory( root, "/c/not-in-this-container" ) == 5400 );
}

TEST( test_quotas_of_processor_time )
{
    const char* root = cli_folder();
    assert_true( rf_cgroup_cores( root, "/" ) == (double)INFINITY ); // no such files
    cli_expect( cli_run( "mkdir -p q/r; echo max 100000 > q/r/cpu.max" ), 0, NULL );
    assert_true( rf_cgroup_cores( root, "/q/r" ) == (double)INFINITY );
    cli_expect( cli_run( "echo 150000 100000 > q/cpu.max" ), 0, NULL );
    assert_true( rf_cgroup_cores( root, "/q/r" ) == 1.5 ); // that of the group above
    cli_expect( cli_run( "mkdir -p s/t; echo -1 > s/t/cpu.cfs_quota_us; echo 100000 > s/t/cpu.cfs_period_us" ), 0, NULL );
    assert_true( rf_cgroup_cores( root, "/s/t" ) == (double)INFINITY );
    cli_expect( cli_run( "echo 50000 > s/t/cpu.cfs_quota_us" ), 0, NULL );
    assert_true( rf_cgroup_cores( root, "/s/t" ) == 0.5 );
    assert_true( rf_core_count() >= 1 );
}

// "threads" of a render's result where its shell line begins with `before`.
static int threads_of( const char* before, const char* options )
{
    const CliResult* done =
        cli_run( "%s $R render $VASE -o cores/f.####.exr --overwrite --frames 1 --size 16x9 --spp 1 --group 0 "
                 "--quiet --json cores.json %s >told",
                 before, options );
    cli_expect( done, 0, NULL );
    json_auto_t* json = cli_read_json( "cores.json" );
    int threads = (int)json_integer_value( json_object_get( json, "threads" ) );
    return threads;
}

TEST( test_threads_and_cpu_sets_are_respected )
{
    assert_int_equal( threads_of( "", "--threads 3" ), 3 );
    assert_int_equal( threads_of( "nice -n 5", "" ), rf_core_count() ); // niceness is the system's business
    if ( system( "command -v taskset >/dev/null && taskset -c 0 true 2>/dev/null" ) != 0 )
        return; // no such tool, or a set without this core
    assert_int_equal( threads_of( "taskset -c 0", "" ), 1 );
    assert_int_equal( threads_of( "taskset -c 0", "--threads 2" ), 2 ); // as asked for, on one core
}

// A group of this system with half a core, where we may make one.
TEST( test_the_quota_of_the_own_group_counts )
{
    static const char line[] =
        "d=/sys/fs/cgroup/cpu; f=cpu.cfs_quota_us; q=50000; "
        "test -e /sys/fs/cgroup/cgroup.controllers && { d=/sys/fs/cgroup; f=cpu.max; q='50000 100000'; }; "
        "g=$d/reframe-test-$$; mkdir $g 2>/dev/null && echo \"$q\" 2>/dev/null > $g/$f || { rmdir $g 2>/dev/null; exit 77; }; "
        "( echo 0 > $g/cgroup.procs && $R render $VASE -o quota/f.####.exr --frames 1 --size 16x9 --spp 1 --group 0 --quiet "
        "--json quota.json >told ); s=$?; rmdir $g; exit $s";
    const CliResult* done = cli_run( "{ %s; } 2>/dev/null", line );
    if ( done->status == 77 || done->status == 2 )
        skip();
    cli_expect( done, 0, NULL );
    json_auto_t* json = cli_read_json( "quota.json" );
    assert_int_equal( json_integer_value( json_object_get( json, "threads" ) ), 1 );
}

TEST( test_a_limit_below_the_need_is_an_error_at_the_start )
{
#ifdef REFRAME_SANITIZED // its address space has no bounds
    skip();
#endif
#define RENDER "ulimit -v 700000; $R render $VASE -o limit/f.####.exr --frames 1-7 --group 3 --spp 7 --threads 1 --quiet --size "
    cli_expect( cli_run( RENDER "3840x2160 --memory 4G" ), 1, "limit of this process (control group, ulimit -v) leaves" );
    cli_expect( cli_run( "test ! -e limit || test -z \"$(ls limit)\"" ), 0, NULL );
    cli_expect( cli_run( RENDER "64x36" ), 0, NULL ); // the default budget heeds the limit
#undef RENDER
}

static void write_textured( const char* name, int images )
{
    static const float corners[15] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1 };
    char text[16384] = "", parts[4][4096] = { "", "", "", "" };
    for ( int i = 0; i < images; ++i )
    {
        const char* comma = i > 0 ? "," : "";
        size_t used[4];
        for ( int k = 0; k < 4; ++k )
            used[k] = strlen( parts[k] );
        snprintf( parts[0] + used[0], 4096 - used[0], "%s{\"uri\":\"t.png\"}", comma );
        snprintf( parts[1] + used[1], 4096 - used[1], "%s{\"source\":%d}", comma, i );
        snprintf( parts[2] + used[2], 4096 - used[2],
                  "%s{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":{\"index\":%d}}}", comma, i );
        snprintf( parts[3] + used[3], 4096 - used[3], "%s{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":%d}",
                  comma, i );
    }
    snprintf( text, sizeof text,
              "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"t.bin\",\"byteLength\":60}],"
              "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":24}],"
              "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],"
              "\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
              "\"images\":[%s],\"textures\":[%s],\"materials\":[%s],\"meshes\":[{\"primitives\":[%s]}],"
              "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]}",
              parts[0], parts[1], parts[2], parts[3] );
    cli_write( "t.bin", corners, sizeof corners );
    cli_write( name, text, strlen( text ) );
}

TEST( test_textures_beyond_memory_are_an_error )
{
#ifdef REFRAME_SANITIZED
    skip();
#endif
    uint8_t header[64], grey[4] = { 0 };
    cli_write( "t.png", header, promise_png( header, 8192, 8192 ) ); // nothing is decoded
    write_textured( "many.gltf", 16 );
    cli_expect( cli_run( "ulimit -v 700000; $R info many.gltf" ), 1,
                "many.gltf: its 16 textures need 5461 MiB of memory, of which" );
    cli_expect( cli_run( "ulimit -v 700000; $R info many.gltf" ), 1,
                "MiB are available: scale them down, first images[0] 't.png' (8192x8192, 256 MiB), images[1]" );
    size_t size;
    AUTO_FREE uint8_t* png = encode_png( 2, 2, 1, grey, &size );
    cli_write( "t.png", png, size );
    cli_expect( cli_run( "ulimit -v 700000; $R info many.gltf" ), 0, NULL );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
