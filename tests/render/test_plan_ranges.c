// Ranges of frames for several machines: they hold every frame once, take what a render of them takes, are as even as can be,
// and are cut where the halo is least.
#include "support/test.h"
#include "reframe/plan.h"
#include "render/groups.h"

#include <math.h>
#include <stdlib.h>

#define MOST 200

static RfRenderSettings settings_of( int group, int spp )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.filter = RF_FILTER_BOX;
    settings.group = group;
    settings.spp = spp;
    return settings;
}

// Samples per pixel of the groups that hold any of the eyes, counted one by one.
static double samples_of( const RfGroupPlan* plan, const int* eyes, int first, int end )
{
    double samples = 0.0;
    for ( int g = 0; g < plan->groups; ++g )
    {
        RfGroup group = rf_group( plan, g );
        int i = first;
        while ( i < end && ( eyes[i] < group.first || eyes[i] >= group.first + group.eyes ) )
            ++i;
        samples += i < end ? (double)group.passes * group.eyes : 0.0;
    }
    return samples;
}

// The least that the longest of so many ranges can take, by trying all cuts.
static double least_longest( const RfGroupPlan* plan, const int* eyes, int count, int ranges )
{
    static double best[9][MOST + 1];
    for ( int end = 0; end <= count; ++end )
        best[0][end] = end == 0 ? 0.0 : (double)INFINITY;
    for ( int k = 1; k <= ranges; ++k )
        for ( int end = 0; end <= count; ++end )
        {
            best[k][end] = best[k - 1][end];
            for ( int cut = 0; cut < end; ++cut )
                best[k][end] = fmin( best[k][end], fmax( best[k - 1][cut], samples_of( plan, eyes, cut, end ) ) );
        }
    return best[ranges][count];
}

static double check_ranges( int eye_count, const int* eyes, int count, int group, int spp, int machines )
{
    RfPlanRange ranges[MOST];
    RfError error;
    int found;
    RfRenderSettings settings = settings_of( group, spp );
    RfGroupPlan plan = rf_plan_groups( eye_count, group, spp );
    RfShot shot = { .eye_count = eye_count, .frames = eyes, .frame_count = count };
    assert_int_equal( rf_plan_ranges( &shot, &settings, machines, ranges, &found, &error ), RF_OK );
    assert_int_equal( found, machines < count ? machines : count );
    double whole = samples_of( &plan, eyes, 0, count ), longest = 0.0, sum = 0.0;
    for ( int i = 0; i < found; ++i )
    {
        assert_int_equal( ranges[i].first, i == 0 ? 0 : ranges[i - 1].end );
        assert_true( ranges[i].end > ranges[i].first );
        double samples = samples_of( &plan, eyes, ranges[i].first, ranges[i].end );
        assert_true( fabs( ranges[i].work * whole - samples ) <= 1e-9 * whole );
        longest = fmax( longest, samples );
        sum += ranges[i].work;
    }
    assert_int_equal( ranges[found - 1].end, count );
    assert_true( longest <= 1.0501 * least_longest( &plan, eyes, count, found ) );
    return sum - 1.0;
}

TEST( test_ranges_are_whole_and_even )
{
    static const int s_groups[] = { 0, 1, 3, 6 }, s_machines[] = { 1, 2, 3, 7 };
    int eyes[24];
    for ( int i = 0; i < 24; ++i )
        eyes[i] = i;
    for ( size_t g = 0; g < 4; ++g )
        for ( size_t m = 0; m < 4; ++m )
        {
            double overhead = check_ranges( 24, eyes, 24, s_groups[g], 28, s_machines[m] );
            assert_true( s_groups[g] == 0 || s_machines[m] == 1 ? fabs( overhead ) < 1e-12 : overhead > 0.0 );
        }
    check_ranges( 24, eyes, 3, 1, 9, 7 ); // more machines than frames
}

// A cut in a gap of the frames asked for costs less, within a gap of a whole group nothing.
TEST( test_gaps_are_cut_first )
{
    int eyes[20];
    for ( int i = 0; i < 20; ++i )
        eyes[i] = i < 10 ? i : i + 20;
    assert_true( fabs( check_ranges( 40, eyes, 20, 2, 10, 2 ) ) < 1e-12 );
    for ( int i = 0; i < 20; ++i )
        eyes[i] = i < 10 ? i + 10 : i + 12; // two frames are missing: the halo is smaller there
    double here = check_ranges( 60, eyes, 20, 2, 10, 2 );
    for ( int i = 0; i < 20; ++i )
        eyes[i] = i + 10;
    assert_true( here < check_ranges( 60, eyes, 20, 2, 10, 2 ) );
}

// Frames of a camera that stands still share an eye: cut among them, both sides would render it.
TEST( test_a_camera_that_stands_still_is_not_cut )
{
    int eyes[40], found;
    RfPlanRange ranges[4];
    RfError error;
    RfRenderSettings settings = settings_of( 1, 3 );
    for ( int i = 0; i < 40; ++i )
        eyes[i] = i < 18 ? i : i < 22 ? 18 : i - 3; // frames 19 to 22 are one
    RfShot shot = { .eye_count = 37, .frames = eyes, .frame_count = 40 };
    assert_int_equal( rf_plan_ranges( &shot, &settings, 2, ranges, &found, &error ), RF_OK );
    assert_true( eyes[ranges[0].end] != eyes[ranges[0].end - 1] );
    check_ranges( 37, eyes, 40, 1, 3, 2 );
    shot.frame_count = 0;
    assert_int_equal( rf_plan_ranges( &shot, &settings, 2, ranges, &found, &error ), RF_ERROR_USAGE );
}

TEST( test_long_paths_take_no_time )
{
    int count = 100000, found;
    int* eyes = malloc( (size_t)count * sizeof( int ) );
    RfPlanRange ranges[100];
    RfError error;
    RfRenderSettings settings = settings_of( 3, 28 );
    assert_non_null( eyes );
    for ( int i = 0; i < count; ++i )
        eyes[i] = i;
    RfShot shot = { .eye_count = count, .frames = eyes, .frame_count = count };
    assert_int_equal( rf_plan_ranges( &shot, &settings, 100, ranges, &found, &error ), RF_OK );
    assert_int_equal( found, 100 );
    assert_int_equal( ranges[99].end, count );
    free( eyes );
}
