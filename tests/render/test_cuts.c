// Cuts: each shot of a path is grouped and rendered as a path of its own, whatever lies on the other side.
#include "measure/trial.h"
#include "render/groups.h"
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 23
#define HEIGHT 18

static const int lengths[][5] = { { 1, 3, 20, 9, 5 }, { 4, 4, 1, 1, 2 }, { 60, 7, 15, 14, 1 } };
static const int half_widths[] = { 0, 1, 2, 3, 7, RF_MAX_GROUP };
static const int sample_counts[] = { 1, 5, 28, 101 };

#define COUNT( array ) (int)( sizeof( array ) / sizeof *( array ) )
#define MOST_FRAMES 128

// Cameras of shots of these lengths; their numbers have gaps.
static int cut_path( const int shots[5], RfEye* eyes )
{
    int count = 0;
    for ( int s = 0; s < 5; ++s )
    {
        for ( int i = 0; i < shots[s]; ++i )
            eyes[count++] = ( RfEye ){ .shot = s * s };
    }
    return count;
}

static void check_shot( const RfGroupPlan* plan, int start, int length, int half_width )
{
    RfGroupPlan own = rf_plan_groups( length, half_width, plan->spp );
    assert_int_equal( own.spp, plan->spp ); // rounded for all shots alike
    for ( int frame = 0; frame < length; ++frame )
    {
        int first, last, own_first, own_last, begin, end;
        rf_groups_of_frame( plan, start + frame, &first, &last );
        rf_groups_of_frame( &own, frame, &own_first, &own_last );
        assert_int_equal( last - first, own_last - own_first );
        for ( int k = 0; first + k <= last; ++k )
        {
            RfGroup group = rf_group( plan, first + k ), wanted = rf_group( &own, own_first + k );
            wanted.first += start;
            assert_memory_equal( &group, &wanted, sizeof group );
        }
        assert_int_equal( rf_frame_passes( plan, start + frame ), rf_frame_passes( &own, frame ) );
        rf_shot_of_frame( plan, start + frame, &begin, &end );
        assert_true( begin == start && end == start + length );
        assert_true( !rf_share_shot( plan, start, start + length ) && rf_share_shot( plan, start, start + frame ) );
    }
}

TEST( test_shots_are_grouped_like_paths )
{
    for ( int i = 0; i < COUNT( lengths ) * COUNT( half_widths ) * COUNT( sample_counts ); ++i )
    {
        const int* shots = lengths[i % COUNT( lengths )];
        int half_width = half_widths[i / COUNT( lengths ) % COUNT( half_widths )];
        int spp = sample_counts[i / COUNT( lengths ) / COUNT( half_widths )];
        RfEye eyes[MOST_FRAMES];
        int count = cut_path( shots, eyes ), longest = 0;
        RfGroupPlan plan = rf_plan_shots( eyes, count, half_width, spp );
        for ( int s = 0, start = 0; s < 5; start += shots[s++] )
        {
            check_shot( &plan, start, shots[s], half_width );
            longest = shots[s] > longest ? shots[s] : longest;
        }
        assert_int_equal( plan.eyes, 2 * half_width + 1 < longest ? 2 * half_width + 1 : longest );
        RfGroupPlan again = rf_plan_shots( eyes, count, plan.eyes / 2, plan.spp );
        assert_true( again.eyes == plan.eyes && again.spp == plan.spp && again.passes == plan.passes );
        double frames = 0.0; // each group of frames has one number; other numbers have none
        for ( int g = 0, before = -1; g < plan.groups; ++g )
        {
            RfGroup group = rf_group( &plan, g );
            assert_true( group.eyes == 0 ? group.passes == 0 : group.first >= before );
            before = group.eyes > 0 ? group.first : before;
            frames += group.eyes;
        }
        for ( int f = 0; f < count; ++f )
        {
            int first, last;
            rf_groups_of_frame( &plan, f, &first, &last );
            frames -= last - first + 1;
        }
        assert_true( frames == 0.0 );
    }
}

TEST( test_paths_without_cuts )
{
    RfEye eyes[9];
    for ( int i = 0; i < 9; ++i )
        eyes[i] = ( RfEye ){ .shot = 3 };
    RfGroupPlan plan = rf_plan_shots( eyes, 9, 2, 5 ), plain = rf_plan_groups( 9, 2, 5 ),
                unknown = rf_plan_shots( NULL, 9, 2, 5 );
    assert_true( plan.cameras == NULL && unknown.cameras == NULL );
    assert_true( plan.groups == plain.groups && unknown.groups == plain.groups );
}

// Two orbits of a room, far from each other.
#define FIRST 6
#define SECOND 7
#define ALL ( FIRST + SECOND )

static void begin( Stage* s, RoomKind room, double shutter )
{
    open_stage( s, make_room( room ), FIRST, 4.0f, WIDTH, HEIGHT );
    s->eye_count = ALL;
    orbit_eyes( s->eyes + FIRST, SECOND, 2.0f, WIDTH, HEIGHT );
    for ( int i = 0; i < ALL; ++i )
    {
        s->eyes[i].shot = i >= FIRST ? 2 : 0;
        RfEye open = s->eyes[i], close = open;
        open.origin.y -= (float)shutter;
        close.origin.y += (float)shutter;
        if ( shutter > 0.0 )
            rf_set_shutter( s->eyes + i, &open, &close );
    }
}

// The first shot alone; all with another first shot.
static const RfFrameResult* render_first( Stage* s, const RfRenderSettings* settings )
{
    s->eye_count = FIRST;
    const RfFrameResult* first = render_stage( s, settings );
    s->eye_count = ALL;
    return first;
}

static const RfFrameResult* render_other( Stage* s, const RfRenderSettings* settings )
{
    RfEye eyes[FIRST];
    memcpy( eyes, s->eyes, sizeof eyes );
    orbit_eyes( s->eyes, FIRST, 3.0f, WIDTH, HEIGHT );
    const RfFrameResult* other = render_stage( s, settings );
    memcpy( s->eyes, eyes, sizeof eyes );
    return other;
}

static RfRenderSettings settings_of( int group, const char* tile )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = 15; // a multiple of a group, so that no shot is rounded for another
    settings.threads = 1;
    settings.memory = (size_t)256 << 20;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    return settings;
}

static void assert_same( const RfFrameResult* a, const RfFrameResult* b, int count )
{
    for ( int i = 0; i < count; ++i )
        expect_same_bits( a + i, b + i );
}

// The first shot as it is alone, the second whatever the first is, and each frame as it is in the sequence.
static void check_cut( Stage* s, const RfRenderSettings* settings )
{
    const RfFrameResult *whole = render_stage( s, settings ), *other = render_other( s, settings );
    assert_same( whole, render_first( s, settings ), FIRST );
    assert_same( whole + FIRST, other + FIRST, SECOND );
    assert_memory_not_equal( whole->rgb, other->rgb, 3 * WIDTH * HEIGHT * sizeof( float ) );
    for ( int frame = FIRST - 1; frame <= FIRST && settings->noise == 0.0 && settings->flicker == 0.0; ++frame )
        expect_same_bits( whole + frame, render_one( s, frame, settings ) );
}

TEST( test_frames_beside_a_cut )
{
    Stage c;
    for ( int blurred = 0; blurred < 2; ++blurred )
    {
        begin( &c, ROOM_GGX, 0.1 * blurred );
        for ( int group = 1; group <= 5; group += 2 ) // sliding, cut to the shot, and the whole shot
        {
            RfRenderSettings settings = settings_of( group, group == 1 ? "3x3" : "1" );
            check_cut( &c, &settings );
        }
        RfRenderSettings adaptive = settings_of( 2, "3x3" );
        adaptive.adaptive = RF_ADAPTIVE_ON;
        check_cut( &c, &adaptive );
        close_stage( &c );
    }
}

// A noise or a flicker to stop at: what is known of one shot says nothing of the next.
TEST( test_goals_beside_a_cut )
{
    AUTO_BY( close_stage ) Stage c;
    begin( &c, ROOM_GGX, 0.0 );
    for ( int flicker = 0; flicker < 2; ++flicker )
    {
        RfRenderSettings settings = settings_of( 2, "3x3" );
        settings.spp = 64;
        settings.noise = flicker ? 0.0 : 0.1;
        settings.flicker = flicker ? 0.6 : 0.0;
        const RfFrameResult* first = render_first( &c, &settings );
        assert_same( render_stage( &c, &settings ), first, FIRST );
        assert_int_equal( c.stats.missed + c.stats.flicker_missed, 0 );
    }
}

static double mean_square( const RfFrameResult* a, const RfFrameResult* b )
{
    double sum = 0.0;
    for ( int i = 0; i < 3 * SECOND * WIDTH * HEIGHT; ++i )
    {
        int frame = i / ( 3 * WIDTH * HEIGHT ), k = i % ( 3 * WIDTH * HEIGHT );
        double d = (double)a[frame].rgb[k] - (double)b[frame].rgb[k];
        sum += d * d;
    }
    return sum / ( 3.0 * SECOND * WIDTH * HEIGHT );
}

// The second shot has other random numbers than alone, but the same picture and as much noise.
TEST( test_second_shot_is_as_alone )
{
    AUTO_BY( close_stage ) Stage c;
    begin( &c, ROOM_DIFFUSE, 0.05 );
    AUTO_BY( close_stage ) Stage second;
    open_stage_before( &second, make_room( ROOM_DIFFUSE ), c.eyes + FIRST, SECOND );
    RfRenderSettings settings = settings_of( 1, "3x3" );
    double apart[2] = { 0 };
    for ( int k = 0; k < 8; ++k )
    {
        settings.seed = (uint64_t)( 3 * k + 1 ); // other ones: the same seed has the same shifts in all frames
        const RfFrameResult* whole = render_stage( &c, &settings );
        settings.seed += 1;
        const RfFrameResult* alone = render_stage( &second, &settings );
        settings.seed += 1;
        apart[0] += mean_square( whole + FIRST, alone );
        apart[1] += mean_square( render_stage( &second, &settings ), alone );
        for ( int i = 0; i < SECOND; ++i )
            assert_true( whole[FIRST + i].native_spp == alone[i].native_spp );
    }
    print_message( "cut over alone: %.3f\n", apart[0] / apart[1] );
    assert_true( apart[0] > 0.8 * apart[1] && apart[0] < 1.25 * apart[1] );
}

// Motion of the frames beside the cut, as it is at the ends of a path.
TEST( test_no_motion_across_a_cut )
{
    AUTO_BY( close_stage ) Stage c;
    begin( &c, ROOM_GGX, 0.0 );
    RfRenderSettings settings = settings_of( 1, "1" );
    settings.spp = 3;
    settings.aovs = RF_AOV_BIT( RF_AOV_MOTION );
    const RfFrameResult *whole = render_stage( &c, &settings ), *other = render_other( &c, &settings );
    assert_same( whole, render_first( &c, &settings ), FIRST );
    assert_same( whole + FIRST, other + FIRST, SECOND );
}

// Short renders that tune and cost measure lie within a shot where that is long enough, and have its groups where it is not.
TEST( test_trials_beside_a_cut )
{
    AUTO_BY( close_stage ) Stage c;
    begin( &c, ROOM_GGX, 0.0 );
    RfShot shot = stage_shot( &c, NULL, 0 );
    for ( int frames = 5; frames <= 9; frames += 4 )
    {
        RfRenderSettings settings = settings_of( frames / 2, "3x3" );
        AUTO_BY( rf_destroy_test_region ) RfTestRegion region;
        RfTestSite site = { FIRST, frames, WIDTH * HEIGHT };
        RfTrial trial;
        assert_int_equal( rf_create_test_region( &shot, NULL, &site, &settings, &region, NULL ), RF_OK );
        assert_int_equal( region.first, frames == 5 ? FIRST : FIRST - 4 );
        assert_int_equal( region.frames, frames );
        assert_int_equal( rf_run_trial( &region, 1, 2, &settings, &trial, NULL ), RF_OK );
        assert_true( trial.samples > 0.0 && isfinite( trial.relmse ) );
    }
}

TEST( test_shots_must_not_fall )
{
    AUTO_BY( close_stage ) Stage c;
    begin( &c, ROOM_GGX, 0.0 );
    RfRenderSettings settings = settings_of( 1, "1" );
    c.eyes[ALL - 1].shot = 1;
    expect_refused( &c, &settings, "frame 12" );
}
