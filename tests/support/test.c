#include "support/test.h"

#include "support/statistics.h"

#define MOST_TESTS 64

static struct CMUnitTest s_tests[MOST_TESTS];
static size_t s_count;
static CMFixtureFunction s_set_up, s_tear_down;
static bool s_statistical;

void list_test( struct CMUnitTest test )
{
    if ( s_count == MOST_TESTS )
        abort();
    s_tests[s_count++] = test;
}

void list_shared( CMFixtureFunction set_up, CMFixtureFunction tear_down )
{
    s_set_up = set_up;
    s_tear_down = tear_down;
}

void list_as_statistical( void ) { s_statistical = true; }

int run_listed_tests( void )
{
    if ( s_count == 0 )
        abort(); // a file without tests would pass
    return s_statistical ? run_statistical_tests( s_tests, s_count )
                         : _cmocka_run_group_tests( "tests", s_tests, s_count, s_set_up, s_tear_down );
}
