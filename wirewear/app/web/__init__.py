"""`wirewear open`: a workspace in a browser."""
