// The files of src/page/assets as text, made by scripts/cmake/embed.cmake.
#ifndef REFRAME_PAGE_PAGE_ASSETS_H
#define REFRAME_PAGE_PAGE_ASSETS_H

extern const char rf_page_html[]; // with the marks {{title}} {{style}} {{blocks}} {{data}} {{script}}, in this order
extern const char rf_page_css[];
extern const char rf_page_js[]; // all scripts, in the order of their names

#endif
