// Sliding groups: which groups hold which frames, how many own-frame and effective samples
// each frame gets, and how they split into the halves of (E2).
#include "support/test.h"
#include "render/groups.h"
#include "reframe/render.h"

#include <limits.h>
#include <stdlib.h>

static const int frame_counts[] = { 1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 15, 20, 21, 22, 43, 60, 250 };
static const int half_widths[] = { 0, 1, 2, 3, 4, 7, 8, 10, 31, 124, RF_MAX_GROUP, INT_MAX };
static const int sample_counts[] = { 1, 2, 3, 5, 6, 7, 8, 9, 13, 14, 28, 64, 101, 1000, RF_MAX_SPP };

#define COUNT( array ) (int)( sizeof( array ) / sizeof *( array ) )

typedef void CheckPlan( const RfGroupPlan* plan, int half_width, int spp );

static void for_all_plans( CheckPlan* check )
{
    for ( int f = 0; f < COUNT( frame_counts ); ++f )
    {
        for ( int h = 0; h < COUNT( half_widths ); ++h )
        {
            for ( int s = 0; s < COUNT( sample_counts ); ++s )
            {
                RfGroupPlan plan = rf_plan_groups( frame_counts[f], half_widths[h], sample_counts[s] );
                assert_int_equal( plan.frames, frame_counts[f] );
                check( &plan, half_widths[h], sample_counts[s] );
            }
        }
    }
}

static bool holds( RfGroup window, int frame ) { return frame >= window.first && frame < window.first + window.eyes; }

static bool same_window( RfGroup a, RfGroup b ) { return a.first == b.first && a.eyes == b.eyes; }

static void check_windows( const RfGroupPlan* plan, int half_width, int spp )
{
    (void)spp;
    long whole = 2 * (long)half_width + 1;
    assert_int_equal( plan->eyes, whole < plan->frames ? whole : plan->frames );
    int64_t before = 0;
    for ( int w = 0; w < plan->groups; ++w )
    {
        RfGroup window = rf_group( plan, w );
        assert_true( window.first >= 0 && window.eyes >= 1 && window.eyes <= plan->eyes );
        assert_true( window.first + window.eyes <= plan->frames );
        assert_true( window.passes >= 0 );
        assert_true( window.passes_before == before );
        before += window.passes;
        if ( w > 0 )
        {
            RfGroup last = rf_group( plan, w - 1 );
            assert_true( window.first >= last.first && window.first + window.eyes >= last.first + last.eyes );
            assert_false( same_window( window, last ) );
        }
    }
    for ( int frame = 0; frame < plan->frames; ++frame )
    {
        int first, last;
        rf_groups_of_frame( plan, frame, &first, &last );
        assert_true( first >= 0 && first <= last && last < plan->groups );
        assert_true( last - first < plan->eyes );
        for ( int w = 0; w < plan->groups; ++w )
            assert_int_equal( holds( rf_group( plan, w ), frame ), w >= first && w <= last );
    }
}

TEST( test_windows_cover_the_path ) { for_all_plans( check_windows ); }

// Windows are cut in paths of one to two groups only.
static void check_full( const RfGroupPlan* plan, int half_width, int spp )
{
    (void)half_width;
    (void)spp;
    bool between = plan->eyes > 1 && plan->frames > plan->eyes && plan->frames <= 2 * plan->eyes;
    assert_int_equal( plan->cut, between ? plan->eyes - 1 : 0 );
    assert_int_equal( plan->groups, plan->frames - plan->eyes + 1 + 2 * plan->cut );
    for ( int w = plan->cut; w < plan->groups - plan->cut; ++w )
        assert_int_equal( rf_group( plan, w ).eyes, plan->eyes );
}

TEST( test_long_paths_have_full_windows ) { for_all_plans( check_full ); }

// No more is added than one pass of every eye would bring.
static void check_rounding( const RfGroupPlan* plan, int half_width, int spp )
{
    (void)half_width;
    assert_true( plan->spp >= spp );
    if ( plan->groups == 1 || plan->cut > 0 )
        assert_int_equal( plan->spp, spp );
    else
    {
        assert_true( plan->spp - spp < plan->eyes );
        assert_int_equal( plan->spp, plan->passes * plan->eyes );
    }
    RfGroupPlan again = rf_plan_groups( plan->frames, half_width, plan->spp );
    assert_int_equal( again.spp, plan->spp );
    assert_int_equal( again.passes, plan->passes );
}

TEST( test_rounding_is_minimal ) { for_all_plans( check_rounding ); }

static void check_native( const RfGroupPlan* plan, int half_width, int spp )
{
    (void)half_width;
    (void)spp;
    for ( int frame = 0; frame < plan->frames; ++frame )
    {
        long sum = 0;
        for ( int w = 0; w < plan->groups; ++w )
        {
            RfGroup window = rf_group( plan, w );
            sum += holds( window, frame ) ? window.passes : 0;
        }
        assert_int_equal( rf_frame_passes( plan, frame ), sum );
        assert_true( sum >= plan->spp );
        bool inner = frame >= plan->eyes && frame < plan->groups - 1; // in no end window
        if ( plan->cut == 0 && ( inner || frame == 0 || frame == plan->frames - 1 ) )
            assert_int_equal( sum, plan->spp );
    }
}

TEST( test_own_frame_samples_are_as_planned ) { for_all_plans( check_native ); }

// Native and reused samples that a frame can see: Σ passes × eyes of its windows.
static long effective_samples( const RfGroupPlan* plan, int frame )
{
    int first, last;
    long sum = 0;
    rf_groups_of_frame( plan, frame, &first, &last );
    for ( int w = first; w <= last; ++w )
    {
        RfGroup window = rf_group( plan, w );
        sum += (long)window.passes * window.eyes;
    }
    return sum;
}

// Full windows only: the ends have exactly what the middle has.
static void check_full_ends( const RfGroupPlan* plan )
{
    long enough = (long)plan->spp * plan->eyes, first = effective_samples( plan, 0 );
    assert_int_equal( first, enough );
    assert_int_equal( effective_samples( plan, plan->frames - 1 ), enough );
    for ( int frame = 0; frame < plan->frames; ++frame )
    {
        long here = effective_samples( plan, frame );
        assert_true( here >= enough ); // frames close to an end share its window, and get more
        if ( frame >= plan->eyes && frame < plan->groups - 1 )
            assert_int_equal( here, enough );
    }
}

// Cut windows: no frame has more than 1.3 times the samples of another, but for
// what the rounding to whole passes does where they are few.
static void check_cut_ends( const RfGroupPlan* plan )
{
    long least = LONG_MAX, most = 0;
    for ( int frame = 0; frame < plan->frames; ++frame )
    {
        long here = effective_samples( plan, frame );
        least = here < least ? here : least;
        most = here > most ? here : most;
    }
    assert_true( least > 0 );
    if ( plan->spp >= 2 * plan->eyes )
        assert_true( most <= 1.3 * least );
    assert_true( most <= 1.3 * least + 2.0 * plan->eyes );
}

static void check_ends( const RfGroupPlan* plan, int half_width, int spp )
{
    (void)half_width;
    (void)spp;
    if ( plan->cut == 0 )
        check_full_ends( plan );
    else
        check_cut_ends( plan );
}

TEST( test_the_ends_get_as_many_samples ) { for_all_plans( check_ends ); }

// The halves of every frame differ by one pass at most.
static void check_halves( const RfGroupPlan* plan, int half_width, int spp )
{
    (void)half_width;
    (void)spp;
    if ( plan->spp > 2000 )
        return; // nothing new, and long
    for ( int frame = 0; frame < plan->frames; ++frame )
    {
        int first, last, count[2] = { 0, 0 };
        rf_groups_of_frame( plan, frame, &first, &last );
        for ( int w = first; w <= last; ++w )
        {
            RfGroup window = rf_group( plan, w );
            for ( int pass = 0; pass < window.passes; ++pass )
                count[rf_half_of_pass( &window, pass )] += 1;
        }
        assert_int_equal( count[0] + count[1], rf_frame_passes( plan, frame ) );
        assert_int_equal( abs( count[0] - count[1] ), ( count[0] + count[1] ) & 1 );
    }
}

TEST( test_halves_share_alike ) { for_all_plans( check_halves ); }

// With two passes or more a window both halves see it; with one pass a window
// the windows alternate.
static void check_halves_of_windows( const RfGroupPlan* plan, int half_width, int spp )
{
    (void)half_width;
    (void)spp;
    for ( int w = 0; w < plan->groups; ++w )
    {
        RfGroup window = rf_group( plan, w );
        if ( window.passes > 1 )
            assert_int_not_equal( rf_half_of_pass( &window, 0 ), rf_half_of_pass( &window, 1 ) );
        if ( w + 1 == plan->groups || window.passes == 0 )
            continue;
        RfGroup next = rf_group( plan, w + 1 );
        assert_int_not_equal( rf_half_of_pass( &window, window.passes - 1 ), rf_half_of_pass( &next, 0 ) );
    }
}

TEST( test_halves_see_all_windows ) { for_all_plans( check_halves_of_windows ); }
