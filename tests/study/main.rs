//! Studies, their metrics, and pages in a browser.

#[path = "../common/chromium.rs"]
mod chromium;
#[path = "../common/page.rs"]
mod page;
#[path = "../common/report_page.rs"]
mod report_page;
#[path = "../common/skip.rs"]
mod skip;

mod answers;
mod browser;
mod live;
mod metrics;
mod runs;
