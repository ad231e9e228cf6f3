// The directional albedo of sheen.
#ifndef REFRAME_BSDF_SHEEN_H
#define REFRAME_BSDF_SHEEN_H

// Of white sheen at this cosine, with an error of 0.005 at most: the base keeps what it leaves.
float rf_sheen_albedo( float cos_theta, float alpha );

#endif
