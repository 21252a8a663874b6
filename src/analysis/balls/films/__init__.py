"""Films as cameras write them: frames one after another, with their times and their light."""
