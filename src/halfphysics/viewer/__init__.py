"""Looking at results in a browser: live, recorded, with viser underneath."""
