"""What the paper says of its results, one claim after the other, each with the rule by which runs decide about it."""
