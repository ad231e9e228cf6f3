// The free memory of nested control groups is that of the tightest one, shown on a made-up
// cgroup folder.
#include "base/cgroup.h"
#include "base/system.h"
#include "support/cli_run.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

static void test_the_tightest_group_above_counts( void** state )
{
    (void)state;
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

static void test_groups_of_version_1( void** state )
{
    (void)state;
    const char* root = cli_folder();
    cli_expect(
        cli_run( "mkdir -p c/d; echo 9223372036854771712 > c/d/memory.limit_in_bytes; echo 10 > c/d/memory.usage_in_bytes" ), 0,
        NULL );
    cli_expect( cli_run( "echo 6000 > c/memory.limit_in_bytes; echo 1000 > c/memory.usage_in_bytes" ), 0, NULL );
    cli_expect( cli_run( "printf 'cache 5\ntotal_inactive_file 400\n' > c/memory.stat" ), 0, NULL );
    assert_true( rf_cgroup_free_memory( root, "/c/d" ) == 5400 );
    assert_true( rf_cgroup_free_memory( root, "/c/not-in-this-container" ) == 5400 );
}

static void test_a_limit_below_the_need_is_an_error_at_the_start( void** state )
{
    (void)state;
#ifdef REFRAME_SANITIZED // its address space has no bounds
    skip();
#endif
#define RENDER "ulimit -v 700000; $R render $VASE -o limit/f.####.exr --frames 1-7 --group 3 --spp 7 --threads 1 --quiet --size "
    cli_expect( cli_run( RENDER "3840x2160 --memory 4G" ), 1, "limit of this process (control group, ulimit -v) leaves" );
    cli_expect( cli_run( "test ! -e limit || test -z \"$(ls limit)\"" ), 0, NULL );
    cli_expect( cli_run( RENDER "64x36" ), 0, NULL ); // the default budget heeds the limit
#undef RENDER
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_the_tightest_group_above_counts ),
        cmocka_unit_test( test_groups_of_version_1 ),
        cmocka_unit_test( test_a_limit_below_the_need_is_an_error_at_the_start ),
    };
    return cmocka_run_group_tests_name( "cgroup", tests, cli_enter_group, cli_leave_group );
}
