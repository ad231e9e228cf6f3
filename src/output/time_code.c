// Time codes of frames, with and without dropped numbers.
#include "output/time_code.h"

#include <math.h>
#include <string.h>

#define DAY 86400 // seconds

#define DROP_FLAG ( 1u << 6 )
#define FIELD_MARK ( 1u << 15 )

// Numbers that a minute drops.
static int dropped( RfTimeCodeRate rate ) { return rate.drops ? rate.frames / 15 : 0; }

static bool is_fraction( RfFps fps, int frames )
{
    return fabs( (double)fps.numerator / fps.denominator - frames ) > 1e-6 * frames;
}

RfTimeCodeRate rf_time_code_rate( RfFps fps )
{
    RfTimeCodeRate rate = { 0 };
    if ( fps.numerator < 1 || fps.denominator < 1 )
        return rate;
    double whole = (double)fps.numerator / fps.denominator, slow = 1.001 * whole;
    // 29.97 and 23.976 stand for 30000/1001 and 24000/1001
    double frames = fabs( whole - round( whole ) ) < 1e-6 ? round( whole )
                    : fabs( slow - round( slow ) ) < 1e-3 ? round( slow )
                                                          : 0.0;
    if ( ( frames >= 1.0 && frames <= 30.0 ) || frames == 48.0 || frames == 50.0 || frames == 60.0 )
        rate.frames = (int)frames;
    return rate;
}

RfResult rf_parse_time_code( const char* text, RfFps fps, RfTimeCodeRate* rate, int64_t* frames, RfError* error )
{
    static const int most[4] = { 23, 59, 59, 99 };
    int field[4] = { 0 };
    bool right = strlen( text ) == 11 && text[2] == ':' && text[5] == ':' && ( text[8] == ':' || text[8] == ';' );
    for ( int i = 0; right && i < 4; ++i )
    {
        const char* digits = text + 3 * i;
        field[i] = 10 * ( digits[0] - '0' ) + digits[1] - '0';
        right = strspn( digits, "0123456789" ) == 2 && field[i] <= most[i];
    }
    *rate = rf_time_code_rate( fps );
    *frames = 0;
    if ( !right )
        return rf_fail( error, RF_ERROR_USAGE, "expected HH:MM:SS:FF, as 01:00:00:00, got '%.40s'", text );
    double per_second = (double)fps.numerator / fps.denominator;
    if ( rate->frames == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "no time code of %g frames per second: leave it out", per_second );
    if ( field[3] >= rate->frames )
        return rf_fail( error, RF_ERROR_USAGE, "%s: at %g frames per second the last number is %02d", text, per_second,
                        rate->frames - 1 );
    rate->drops = text[8] == ';';
    if ( rate->drops && ( rate->frames % 30 != 0 || !is_fraction( fps, rate->frames ) ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "%s: only at 29.97 and 59.94 frames per second numbers are dropped: write it as %.8s:%s", text, text,
                        text + 9 );
    int minutes = 60 * field[0] + field[1], drop = dropped( *rate );
    if ( field[1] % 10 != 0 && field[2] == 0 && field[3] < drop )
        return rf_fail( error, RF_ERROR_USAGE, "%s: is dropped in drop-frame time code: the minute begins with %.9s%02d", text,
                        text, drop );
    *frames = ( 60 * (int64_t)minutes + field[2] ) * rate->frames + field[3] - (int64_t)drop * ( minutes - minutes / 10 );
    return RF_OK;
}

static uint32_t bcd( int64_t value ) { return (uint32_t)( value / 10 % 10 ) << 4 | (uint32_t)( value % 10 ); }

uint32_t rf_pack_time_code( RfTimeCodeRate rate, int64_t frames )
{
    if ( rate.frames == 0 )
        return 0;
    int64_t drop = dropped( rate ), minute = 60 * (int64_t)rate.frames - drop, ten = 10 * minute + drop;
    int64_t day = rate.drops ? 144 * ten : DAY * (int64_t)rate.frames, n = ( frames % day + day ) % day, rest = n % ten;
    n += rate.drops ? 9 * drop * ( n / ten ) + ( rest >= drop ? drop * ( ( rest - drop ) / minute ) : 0 ) : 0;
    int64_t number = n % rate.frames, seconds = n / rate.frames;
    bool pairs = rate.frames > 30;
    uint32_t packed = bcd( pairs ? number / 2 : number ) | bcd( seconds % 60 ) << 8 | bcd( seconds / 60 % 60 ) << 16 |
                      bcd( seconds / 3600 ) << 24;
    return packed | ( rate.drops ? DROP_FLAG : 0 ) | ( pairs && number % 2 != 0 ? FIELD_MARK : 0 );
}
