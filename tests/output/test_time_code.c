// Time codes of frames against hand-counted ones and against their definition, number by number.
#include "output/names.h"
#include "support/image_support.h"
#include "support/test.h"

// "HH:MM:SS:FF", ";" where it drops, "." before the second of a pair.
static void format( uint32_t packed, char text[16] )
{
    snprintf( text, 16, "%02x:%02x:%02x%s%02x%s", packed >> 24 & 0x3f, packed >> 16 & 0x7f, packed >> 8 & 0x7f,
              ( packed >> 6 & 1 ) != 0 ? ";" : ":", packed & 0x3f, ( packed >> 15 & 1 ) != 0 ? "." : "" );
}

TEST( test_frame_numbers )
{
    static const struct
    {
        RfFps fps;
        int frame;
        const char* wanted;
    } cases[] = {
        { { 24, 1 }, 0, "00:00:00:00" },
        { { 24, 1 }, 1, "00:00:00:01" },
        { { 24, 1 }, 25, "00:00:01:01" },
        { { 24, 1 }, 100000, "01:09:26:16" },
        { { 25, 1 }, 1, "00:00:00:01" },
        { { 25, 1 }, 25, "00:00:01:00" },
        { { 25, 1 }, 100000, "01:06:40:00" },
        { { 30, 1 }, 1, "00:00:00:01" },
        { { 30, 1 }, 25, "00:00:00:25" },
        { { 30, 1 }, 100000, "00:55:33:10" },
        { { 30000, 1001 }, 1, "00:00:00:01" },
        { { 30000, 1001 }, 25, "00:00:00:25" },
        { { 30000, 1001 }, 100000, "00:55:33:10" },
        { { 60, 1 }, 1, "00:00:00:00." },
        { { 60, 1 }, 25, "00:00:00:12." },
        { { 60, 1 }, 100000, "00:27:46:20" },
        { { 24000, 1001 }, 25, "00:00:01:01" },
        { { 2997, 100 }, 31, "00:00:01:01" },
        { { 48, 1 }, 49, "00:00:01:00." },
        { { 12, 1 }, 13, "00:00:01:01" },
        { { 24, 1 }, -1, "23:59:59:23" },
        { { 24, 1 }, 24 * 86400, "00:00:00:00" },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        char text[16];
        format( rf_pack_time_code( rf_time_code_rate( cases[i].fps ), cases[i].frame ), text );
        if ( strcmp( text, cases[i].wanted ) != 0 )
            fail_msg( "frame %d at %d/%d is %s, not %s", cases[i].frame, cases[i].fps.numerator, cases[i].fps.denominator, text,
                      cases[i].wanted );
    }
    static const RfFps none[] = { { 25, 2 }, { 120, 1 }, { 45, 1 }, { 2398, 100 }, { 1, 2 }, { 0, 0 } };
    for ( size_t i = 0; i < sizeof none / sizeof none[0]; ++i )
        assert_int_equal( rf_time_code_rate( none[i] ).frames, 0 );
}

// A day of numbers, of which the first two or four of each minute but every tenth are passed over, is what is counted and what
// is parsed.
static void check_day( RfFps fps, int step )
{
    RfError error = { 0 };
    RfTimeCodeRate rate;
    int64_t zero, frame = 0;
    assert_int_equal( rf_parse_time_code( "00:00:00;00", fps, &rate, &zero, &error ), RF_OK );
    assert_true( rate.drops && zero == 0 );
    for ( int second = 0; second < 86400; ++second )
    {
        for ( int number = 0; number < rate.frames; ++number )
        {
            if ( second % 60 == 0 && second / 60 % 10 != 0 && number < rate.frames / 15 )
                continue;
            if ( frame++ % step != 0 )
                continue;
            char made[16], text[16], wanted[24];
            format( rf_pack_time_code( rate, frame - 1 ), made );
            bool pairs = rate.frames > 30;
            snprintf( wanted, sizeof wanted, "%02d:%02d:%02d;%02d%s", second / 3600, second / 60 % 60, second % 60,
                      pairs ? number / 2 : number, pairs && number % 2 != 0 ? "." : "" );
            assert_string_equal( made, wanted );
            int64_t parsed;
            RfTimeCodeRate its;
            snprintf( text, sizeof text, "%02d:%02d:%02d;%02d", second / 3600, second / 60 % 60, second % 60, number );
            assert_int_equal( rf_parse_time_code( text, fps, &its, &parsed, &error ), RF_OK );
            assert_true( parsed == frame - 1 );
        }
    }
    assert_int_equal( rf_pack_time_code( rate, frame ), rf_pack_time_code( rate, 0 ) );
}

TEST( test_dropped_numbers )
{
    check_day( ( RfFps ){ 30000, 1001 }, 7 );
    check_day( ( RfFps ){ 60000, 1001 }, 13 );
}

static void expect_error( const char* text, RfFps fps, const char* wanted )
{
    RfError error = { 0 };
    RfTimeCodeRate rate;
    int64_t frames;
    assert_int_equal( rf_parse_time_code( text, fps, &rate, &frames, &error ), RF_ERROR_USAGE );
    if ( strstr( error.text, wanted ) == NULL )
        fail_msg( "'%s': %s", text, error.text );
}

TEST( test_start )
{
    RfError error = { 0 };
    RfTimeCodeRate rate;
    int64_t frames;
    assert_int_equal( rf_parse_time_code( "10:00:00:12", ( RfFps ){ 24, 1 }, &rate, &frames, &error ), RF_OK );
    assert_true( frames == 36000 * 24 + 12 && !rate.drops );
    const RfFps film = { 24, 1 };
    expect_error( "1:00:00:00", film, "expected HH:MM:SS:FF" );
    expect_error( "01:00:00:00x", film, "expected HH:MM:SS:FF" );
    expect_error( "24:00:00:00", film, "expected HH:MM:SS:FF" );
    expect_error( "01:-1:00:00", film, "expected HH:MM:SS:FF" );
    expect_error( "01: 1:00:00", film, "expected HH:MM:SS:FF" );
    expect_error( "", film, "expected HH:MM:SS:FF" );
    expect_error( "01:00:00:24", film, "the last number is 23" );
    expect_error( "01:00:00;00", film, "write it as 01:00:00:00" );
    expect_error( "01:00:00;00", ( RfFps ){ 30, 1 }, "write it as 01:00:00:00" );
    expect_error( "00:01:00;01", ( RfFps ){ 30000, 1001 }, "begins with 00:01:00;02" );
    expect_error( "01:00:00:00", ( RfFps ){ 120, 1 }, "no time code of 120 frames" );
}
