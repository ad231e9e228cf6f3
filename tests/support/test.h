// cmocka, with the parts of the C library that nearly every test calls, and tests that list themselves: a test program is its tests, and
// has no main().
//
//     TEST( test_something )
//     {
//         assert_true( … );
//     }
//
// They run in the order of the file. A program of statistical tests says STATISTICAL_TESTS, one whose tests share something
// SHARED_BY_TESTS( set_up, tear_down ); a main() of its own ends with run_listed_tests().
#ifndef REFRAME_TESTS_TEST_H
#define REFRAME_TESTS_TEST_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/owned.h"

#define TEST( name ) TEST_WITHIN( name, NULL, NULL )

// With functions that are called before and after it.
#define TEST_WITHIN( name, set_up, tear_down )                                                                                   \
    static void name( void** state );                                                                                            \
    __attribute__( ( constructor ) ) static void list_##name( void )                                                             \
    {                                                                                                                            \
        list_test( ( struct CMUnitTest ){ #name, name, set_up, tear_down, NULL } );                                              \
    }                                                                                                                            \
    static void name( __attribute__( ( unused ) ) void** state )

// Called before the first and after the last test.
#define SHARED_BY_TESTS( set_up, tear_down )                                                                                     \
    __attribute__( ( constructor ) ) static void list_fixture( void ) { list_shared( set_up, tear_down ); }

// Those that fail run once more (support/statistics.h).
#define STATISTICAL_TESTS                                                                                                        \
    __attribute__( ( constructor ) ) static void list_statistical( void ) { list_as_statistical(); }

// Returns how many fail.
int run_listed_tests( void );

// What the macros call.
void list_test( struct CMUnitTest test );
void list_shared( CMFixtureFunction set_up, CMFixtureFunction tear_down );
void list_as_statistical( void );

#endif
