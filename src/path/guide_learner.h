// Learns a guide (path/guide.h) from paths.
#ifndef REFRAME_PATH_GUIDE_LEARNER_H
#define REFRAME_PATH_GUIDE_LEARNER_H

#include "path/wavefront.h"

// What a path brought to one of its vertices from the direction in which it went on.
typedef struct RfGuideSample
{
    float p[3];
    float light;                     // luminance times cosine
    float brought;                   // luminance of f · cosine · light over the density
    float pdf_solid_angle, pdf_bsdf; // by which the direction was drawn; of the BSDF alone
    float per_solid_angle;           // of the direction, like `bin` (rf_guide_bin)
    int16_t bin;
    uint8_t axis; // of the normal
} RfGuideSample;

#define RF_MOST_NOTED 16 // vertices of a path

// The vertices of paths that are under way, by slot.
typedef struct RfNotedVertex
{
    RfGuideSample sample; // but for `light` and `brought`
    float cosine;
    float throughput, before; // luminance of the path's, after and before it was scattered
    float found;              // luminance of what it had brought up to then
} RfNotedVertex;

struct RfGuideNotes
{
    int count[RF_LANES];
    RfNotedVertex vertex[RF_LANES][RF_MOST_NOTED];
};

// No vertices of slots [0, count) yet.
void rf_clear_guide_notes( int count, RfGuideNotes* notes );

// Notes the vertices of the wavefront that scattered to the first `count` of the rays `next`, which are not specular.
void rf_note_vertices( const RfWavefront* wavefront, const RfRayLanes* rays, const RfRayLanes* next, int count,
                       RfGuideNotes* notes );

// What the paths of slots [0, count), which have ended, brought to their vertices. Returns how many samples there are, at most
// RF_MOST_NOTED for each slot.
int rf_list_guide_samples( const RfWavefront* wavefront, const RfGuideNotes* notes, int count, RfGuideSample* samples );

// Learns from samples; the same for the same samples in the same order. NULL: out of memory. A guide without tables does nothing.
//
// A leaf has some thousand samples. Its table is a quadtree over the bins, as deep as its samples go, in which each node's light is
// shared out to its quarters by what was found there (Müller, Gross, Novák, Practical Path Guiding, 2017), drawn towards equal
// quarters where that is little. Its share c minimises the cross entropy of what paths brought, of one half of the samples by what
// the other half has learned: so none is guided by noise.
RfGuide* rf_learn_guide( const RfGuideSample* samples, int count );

#endif
