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

int main( void )
{
    const struct CMUnitTest tests[] = { cmocka_unit_test( test_the_tightest_group_above_counts ) };
    return cmocka_run_group_tests_name( "cgroup", tests, cli_enter_group, cli_leave_group );
}
