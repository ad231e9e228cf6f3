// AOVs: what a frame can hold besides its colour. RfRenderSettings.aovs asks for them,
// RfFrameResult.aovs has them, and rf_write_frame writes them as the channels "albedo.R" and so on.
//
//     unsigned aovs;
//     RfResult result = rf_parse_aovs( "albedo,normal,depth", &aovs, &error );
//
// Albedo, normal, those of denoisers, depth and motion are means over the samples that a frame traced itself,
// uniform in the pixel. They hardly have noise, so no other frame's samples are needed.
#ifndef REFRAME_AOV_H
#define REFRAME_AOV_H

#include "reframe/error.h"
#include "reframe/types.h"

RF_API_BEGIN

// The list of AOVs, from which all others are made: X( constant, name, letters of the channels,
// whether 16 bits are enough in a file, what it is made of, what it is ). It is made of
//
//     FILTERED_HITS  the first hits of camera rays, by the pixel filter of the colour, as denoisers and compositors expect
//     HITS           the same by the box of one pixel: a filter would mix more of what is behind into depth and motion
//     FILMS          the films of the colour, or counts of samples
//
// To add one: a row here, what it is in film/aov.c: at a hit and a miss (value_at_hit, value_at_miss), or as made from films
// (rf_finish_aov), and how it is shown (look_of in page/pass_groups.c). The compiler warns of
// each that lacks the row. Options, files, attributes, the budget and the manual follow from it.
#define RF_AOV_LIST( X )                                                                                                         \
    X( ALBEDO, "albedo", "RGB", true, FILTERED_HITS, "reflectance for light along the normal; 0 where nothing is hit" )          \
    X( NORMAL, "normal", "XYZ", true, FILTERED_HITS,                                                                             \
       "shading normal in world space, on the side that is seen; 0 where nothing is hit" )                                       \
    X( DENOISE_ALBEDO, "denoise_albedo", "RGB", true, FILTERED_HITS,                                                             \
       "albedo for denoisers, 0 to 1: of the first surfaces that are no mirror and no clear glass, with what they and the "      \
       "sky emit" )                                                                                                              \
    X( DENOISE_NORMAL, "denoise_normal", "XYZ", true, FILTERED_HITS,                                                             \
       "normal for denoisers, in world space: of the same surfaces, by what mirrors and glass show of each; 0 for the sky" )     \
    X( DEPTH, "depth", "Z", false, HITS,                                                                                         \
       "metres along the viewing direction (not distance to the camera), mean over the hits; 1e10 where no "                     \
       "sample hits anything" )                                                                                                  \
    X( MOTION, "motion", "XYZW", false, HITS,                                                                                    \
       "X and Y: film position in the path's previous frame minus that in this frame, pixels, +x right, +y "                     \
       "up, of the same point of its surface, which may move; Z and W: the same for the next frame (Blender 3.4 has X and Y "    \
       "like this, Z and W with the opposite sign); 0 at the ends of the path, for points behind the other camera, and for "     \
       "what is not there in the other frame" )                                                                                  \
    X( VARIANCE, "variance", "RGB", false, FILMS, "estimated variance of the colour; 0 where a frame has a single pass" )        \
    X( HALF, "half", "RGBW", false, FILMS,                                                                                       \
       "the picture by every other pass alone, and in W their share of the samples: two halves that know nothing of each "       \
       "other tell the error of what is made of them, as by reframe denoise" )                                                   \
    X( SAMPLES, "samples", "Y", false, FILMS,                                                                                    \
       "effective samples: all that landed in the pixel, reused ones too, each counted once" )                                   \
    X( OBJECT_INDEX, "object_index", "X", false, FILMS,                                                                          \
       "pass index of the object that covers most of the pixel: extras.reframe.pass_index of its node; where no node has one, "  \
       "1 + "                                                                                                                    \
       "the number of the node; 0 where nothing covers most" )                                                                   \
    X( MATERIAL_INDEX, "material_index", "X", false, FILMS, "the same of the material" )                                         \
    X( REMOVED, "removed", "RGB", true, FILMS,                                                                                   \
       "with a clamp: the light that it has taken out; colour and this together are the picture without bias" )                  \
    X( EMISSION, "emission", "RGB", true, FILMS,                                                                                 \
       "what camera rays see shine, straight or through panes: emitters and, without alpha, the sky" )                           \
    X( DIRECT, "direct", "RGB", true, FILMS, "light that comes to the first surface from lights straight" )                      \
    X( INDIRECT, "indirect", "RGB", true, FILMS, "all other light of first surfaces that are seen straight" )                    \
    X( REFLECTION, "reflection", "RGB", true, FILMS,                                                                             \
       "all light that camera rays see by mirrors, glass and smooth coats, where the first of them reflects" )                   \
    X( TRANSMISSION, "transmission", "RGB", true, FILMS, "and where it transmits; these five add up to the colour" )             \
    X( PRIMAL, "primal", "RGB", false, FILMS,                                                                                    \
       "of the estimator gradient alone: the pixels that the picture is reconstructed from" )                                    \
    X( DX, "dx", "RGB", false, FILMS, "and their differences, the pixel on the right minus the pixel" )                          \
    X( DY, "dy", "RGB", false, FILMS, "the pixel below minus the pixel" )

// RF_AOV_ALBEDO, RF_AOV_NORMAL and so on, in the order of the list.
typedef enum RfAov
{
#define RF_AOV_CONSTANT( constant, name, letters, half, source, what ) RF_AOV_##constant,
    RF_AOV_LIST( RF_AOV_CONSTANT )
#undef RF_AOV_CONSTANT
        RF_AOV_ALPHA, // not in the list: it belongs to the colour, see below
    RF_AOV_COUNT
} RfAov;

#define RF_AOV_BIT( aov ) ( 1u << ( aov ) )
#define RF_ALL_AOVS ( RF_AOV_BIT( RF_AOV_ALPHA ) - 1u ) // of the list
#define RF_DENOISE_AOVS ( RF_AOV_BIT( RF_AOV_DENOISE_ALBEDO ) | RF_AOV_BIT( RF_AOV_DENOISE_NORMAL ) )
// The colour split by how light comes to the camera. They are reused and combined as the colour is, so each is unbiased.
#define RF_PASS_AOVS                                                                                                             \
    ( RF_AOV_BIT( RF_AOV_EMISSION ) | RF_AOV_BIT( RF_AOV_DIRECT ) | RF_AOV_BIT( RF_AOV_INDIRECT ) |                              \
      RF_AOV_BIT( RF_AOV_REFLECTION ) | RF_AOV_BIT( RF_AOV_TRANSMISSION ) )
#define RF_GRADIENT_AOVS                                                                                                         \
    ( RF_AOV_BIT( RF_AOV_PRIMAL ) | RF_AOV_BIT( RF_AOV_DX ) | RF_AOV_BIT( RF_AOV_DY ) ) // of "gradient" alone
#define RF_GRADIENT_AOVS_NAME "gradients"                                               // all three

// RF_AOV_ALPHA is the coverage of a pixel by what is not sky, 0 to 1: the share of its camera rays that hit something, be
// it a mirror or glass. It is reused and combined as the colour is, so it is unbiased, and where the weights of reused
// samples vary it may leave 0 to 1 a little, at the rims of things. With it the colour is premultiplied: the sky that
// camera rays see is left out of it. What mirrors and glass show of the sky stays. In a file it is the channel "A".

#define RF_DEPTH_OF_NOTHING 1e10f // depth where the whole pixel is empty, as Blender has it

// The name of an AOV, such as "albedo".
const char* rf_aov_name( RfAov aov );

// The letters of its channels, such as "RGB": in a file they are albedo.R, albedo.G, albedo.B.
const char* rf_aov_letters( RfAov aov );

// Its floats per pixel: as many as letters.
int rf_aov_channels( RfAov aov );

// "albedo,depth" to a set of RF_AOV_BITs, "gradients" to RF_GRADIENT_AOVS; NULL is none. Fails with RF_ERROR_USAGE for a word that
// is no AOV (naming the nearest, or all) or comes twice.
RfResult rf_parse_aovs( const char* text, unsigned* aovs, RfError* error );

// A set of RF_AOV_BITs to "albedo,depth", in the order of the list. RF_AOVS_TEXT_SIZE bytes are always enough.
void rf_format_aovs( unsigned aovs, char* text, size_t size );

#define RF_AOVS_TEXT_SIZE 320

// Cryptomatte: mattes of all objects, materials and assets of a frame by their names, as coverage of the pixels by the first
// surfaces that camera rays hit, by the pixel filter of the colour, reused as the colour is. RfRenderSettings.cryptomatte asks
// for kinds; RfFrameResult.layers has each as CryptoObject00 to 02 and so on, of six ranks, and rf_write_frame adds the names.
// An object is a node of the scene's file, or what extras.reframe.object of the node names; an asset the object that is above all
// others, or what extras.reframe.asset names.
#define RF_CRYPTOMATTE_OBJECT 1u
#define RF_CRYPTOMATTE_MATERIAL 2u
#define RF_CRYPTOMATTE_ASSET 4u

// "object,material" to a set of them; NULL is none. Fails with RF_ERROR_USAGE for a word that is none of "object", "material" and
// "asset", or comes twice.
RfResult rf_parse_cryptomatte( const char* text, unsigned* kinds, RfError* error );

// And back, in this order.
#define RF_CRYPTOMATTE_TEXT_SIZE 32
void rf_format_cryptomatte( unsigned kinds, char text[RF_CRYPTOMATTE_TEXT_SIZE] );

RF_API_END

#endif
