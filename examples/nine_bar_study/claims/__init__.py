"""Claims of a published study: their parts, measures and rules, and the page of verdicts."""
