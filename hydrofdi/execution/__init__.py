"""What a sweep will do, where and how its jobs are run, and what its folder tells."""
