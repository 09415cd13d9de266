"""What people see of a study: pictures, and a page that says what was found and how to find it again."""
