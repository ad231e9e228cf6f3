// Where the error of a finished frame is: of which kind are the pixels that stand out (RfSpeckList), and on which material.
//
// 1024 camera rays through the worst of them follow mirrors and glass to the first surface that is not specular, and take emission
// and direct light there: what makes glints. A pixel is one where their variance, over its samples, explains an eighth of its
// error, or less if that is still far more than the noise of the other pixels. Glints that few samples find are missed in
// some pixels: where the specks of a material have such variance in the mean, all of them are glints. The rest came by longer
// paths, which would have to be traced by the thousand to find it again: where the scene has mirrors, glass or gloss it is
// taken for light that these have sent on by chance.
//
// The rays cost less than the samples of 1024 pixels in one pass, and there are none where nothing stands out. They have random
// numbers of their own and change no picture; they are not in RfRayCounts.
#ifndef REFRAME_RENDER_SPECKS_H
#define REFRAME_RENDER_SPECKS_H

#include "render/renderer.h"

// The specks of a frame of the group in work, by its films. Without kinds where the estimator's workspace is too small for it:
// it borrows that of a thread, and lays it out again.
void rf_find_specks( RfRenderer* renderer, const RfLiveFilm* live, const RfSpeckList* list, RfSpecks* specks );

#endif
