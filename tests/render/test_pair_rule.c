// What a pair of frames will flicker when both are finished, predicted after some of their groups: by numbers alone, for
// samples of variance 1 of which a common one has the correlation RHO in two neighbouring frames.
#include "support/test.h"
#include "render/stop/stop_rule.h"

#include <math.h>
#include <stdio.h>

#define RHO 0.9

typedef struct Path
{
    RfStopRule rule;
    int rate; // passes of each share
} Path;

static Path make_path( int frames, int group )
{
    RfGroupPlan plan = rf_plan_groups( frames, group, 28 );
    return ( Path ){ rf_create_stop( &plan, 1 << 16, &( RfStopGoals ){ .flicker = 0.01 } ).rule, 3 };
}

// Weight of the groups up to `end` that hold both frames.
static double weight_until( const Path* path, int frame, int other, int end )
{
    int first, last, other_first, other_last;
    rf_groups_of_frame( &path->rule.plan, frame, &first, &last );
    rf_groups_of_frame( &path->rule.plan, other, &other_first, &other_last );
    first = first > other_first ? first : other_first;
    last = last < other_last ? last : other_last;
    double all = rf_planned_weight( &path->rule, frame, first );
    double after = rf_planned_weight( &path->rule, frame, ( last < end ? last : end ) + 1 );
    return last < first ? 0.0 : path->rate * ( all - after );
}

static RfFlicker flicker_of( const Path* path, int frame, int end )
{
    double s = weight_until( path, frame, frame, end ), t = weight_until( path, frame + 1, frame + 1, end );
    double both = weight_until( path, frame, frame + 1, end );
    return ( RfFlicker ){ .before = 1.0 / s, .now = 1.0 / t, .product = RHO * both / ( s * t ) };
}

static RfFrameNoise known( const Path* path, int frame, int end )
{
    double weight = weight_until( path, frame, frame, end );
    return ( RfFrameNoise ){ .frame = frame, .weight = weight, .seen = weight };
}

// From any group that holds both frames on, in the middle of the path and at its ends.
TEST( test_the_finished_pair_is_predicted )
{
    static const int shapes[][2] = { { 48, 3 }, { 48, 1 }, { 48, 8 }, { 17, 8 }, { 20, 3 } };
    for ( size_t k = 0; k < sizeof shapes / sizeof shapes[0]; ++k )
    {
        Path path = make_path( shapes[k][0], shapes[k][1] );
        for ( int frame = 0; frame + 1 < shapes[k][0]; ++frame )
        {
            int first, last, next_first, next_last;
            rf_groups_of_frame( &path.rule.plan, frame, &first, &last );
            rf_groups_of_frame( &path.rule.plan, frame + 1, &next_first, &next_last );
            RfFlicker end = flicker_of( &path, frame, next_last );
            double wanted = rf_flicker_f1_squared( &end ) * weight_until( &path, frame, frame, last );
            for ( int group = next_first; group <= last; ++group )
            {
                RfFrameNoise before = known( &path, frame, group ), now = known( &path, frame + 1, group );
                RfPairNow pair = { group, &before, &now, flicker_of( &path, frame, group ), 0.0 };
                double found = rf_final_flicker( &path.rule, &pair );
                assert_true( fabs( found - wanted ) <= 1e-9 * wanted );
            }
        }
    }
}

// Where much is shared, further samples of the later frame alone make a pair flicker more: none are asked for. Where
// nothing is, so many that it comes down to what is wanted.
TEST( test_the_later_frame_mends_what_it_can )
{
    Path path = make_path( 48, 3 );
    RfFrameNoise now = { .frame = 20, .weight = 100.0, .seen = 100.0 };
    RfFlicker shared = { .before = 0.02, .now = 0.02, .product = 0.012 },
              apart = { .before = 0.004, .now = 0.009, .product = 0.0 };
    RfFlicker hopeless = { .before = 0.011, .now = 0.009 }, enough = { .before = 0.002, .now = 0.002 };
    assert_true( rf_flicker_f1_squared( &shared ) > path.rule.goals.flicker );
    assert_true( rf_late_flicker( &path.rule, &now, &shared ) == 0.0 );
    assert_true( rf_late_flicker( &path.rule, &now, &hopeless ) == 0.0 );
    assert_true( rf_late_flicker( &path.rule, &now, &enough ) == 0.0 );
    double needed = rf_late_flicker( &path.rule, &now, &apart ) / path.rule.goals.flicker;
    assert_true( fabs( apart.before + apart.now * now.weight / needed - path.rule.goals.flicker ) < 1e-12 );
}
