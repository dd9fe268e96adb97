"""Is the estimate right, is its sigma honest: residuals, consistency, validation, comparison, verdict."""
