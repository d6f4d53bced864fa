"""Contact laws as values: normal force, friction, lubricant."""
